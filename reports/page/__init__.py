"""The report page.

Read `report` (writes everything), `pictures` (which figures there are), `page` (from data to HTML, with the
template ``report.html.j2``), `freshness` (whether a report must be made again). All of it may be changed
without harm to results.
"""
