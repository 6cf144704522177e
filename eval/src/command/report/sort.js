"use strict";
// A click on a column's head sorts by it: numbers by their value, other texts by their letters.
for (const button of document.querySelectorAll("thead button")) {
  button.addEventListener("click", () => {
    const head = button.parentElement;
    const rising = head.getAttribute("aria-sort") !== "ascending";
    const column = head.cellIndex;
    const body = head.closest("table").tBodies[0];
    const text = (row) => row.cells[column].textContent;
    const order = (a, b) => {
      const [x, y] = [parseFloat(text(a)), parseFloat(text(b))];
      if (isNaN(x) || isNaN(y)) {
        return isNaN(x) === isNaN(y) ? text(a).localeCompare(text(b)) * (rising ? 1 : -1) : isNaN(x) - isNaN(y);
      }
      return (x - y) * (rising ? 1 : -1);
    };
    for (const other of head.parentElement.cells) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", rising ? "ascending" : "descending");
    body.append(...[...body.rows].sort(order));
  });
}
