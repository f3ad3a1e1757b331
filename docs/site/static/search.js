// Search in the site, over Sphinx's own (searchtools.js).

// Pages of file:// may not read one another, which summaries of results need.
if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;

// Among pages of equal scores the first steps come first, not the first of the alphabet.
document.addEventListener("DOMContentLoaded", () => {
  if (typeof Scorer === "undefined") return; // a page without search
  Scorer.score = ([page, , , , score]) => (page === "quick_start" ? score + 1 : score);
});
