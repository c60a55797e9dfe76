// How the search of the site sorts what it finds: a page whose title has all that was typed comes first.
const typed = (new URLSearchParams(location.search).get("q") || "").toLowerCase().split(/\s+/).filter(Boolean);

var Scorer = {
  score: ([, title, anchor, , score]) => {
    const words = title.toLowerCase();
    return score + (!anchor && typed.every((word) => words.includes(word)) ? 100 : 0);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
