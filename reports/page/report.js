const filter = document.getElementById("filter");
if (filter) {
  filter.addEventListener("change", () => {
    for (const figure of document.querySelectorAll("#pairs figure")) {
      figure.hidden = filter.value !== "" && figure.dataset.group !== filter.value;
    }
  });
}
window.addEventListener("beforeprint", () => {
  for (const image of document.images) image.loading = "eager";
});
