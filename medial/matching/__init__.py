"""Matching of two clouds by their diffusions: Sec. 4, and what holds with data missing.

Read `match` first: it is the pipeline, top to bottom. Then

* `config`, `result`: what goes in and what comes out,
* `prepared`: both clouds in common units (`common_units`), with samples and tables,
* `landmarks`: Eqs. 16 and 17, landmarks by path length, rigid motions; `candidate_batches` says which of them
  are tried in which direction,
* `fit_search`: from candidates to settled fits,
* `registration`: deform one cloud onto the other, search among the fits, select one,
* `confidence`, `mirror_check`: what is said of the map; `zoomout`: spectral refinement.

`nearest` and `neighbourhoods` serve all of these. `result` may be changed without harm to maps; every other
module decides results, down to the order of lists, which breaks ties.
"""
