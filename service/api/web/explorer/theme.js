/** Light, dark, or as the system has it. */

const KEY = "rpr-cusps-theme";
const chooser = document.getElementById("theme");

function apply(theme) {
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
}

function kept() {
  try {
    return localStorage.getItem(KEY) ?? "auto";
  } catch {
    return "auto"; // a browser that keeps nothing
  }
}

chooser.value = kept();
apply(chooser.value);
chooser.addEventListener("change", () => {
  apply(chooser.value);
  try {
    localStorage.setItem(KEY, chooser.value);
  } catch {
    // then it holds until the page is closed
  }
});
