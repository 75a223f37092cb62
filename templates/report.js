"use strict";
// Tables sort and filter, figures tell their values. The page says all of it without this script.
(() => {
  const SORTED_FROM = 5, FILTERED_FROM = 10, FAR = 120;
  const make = (kind, fields, ...inside) => {
    const element = Object.assign(document.createElement(kind), fields);
    element.append(...inside);
    return element;
  };
  const said = make("p", { className: "unseen" });
  said.setAttribute("role", "status");
  document.querySelector("main").append(said);

  // The first number of a cell as it is typeset: a true minus, a power of ten in raised digits.
  const RAISED = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
  const number = (text) => {
    const found = /([\u2212+-]?\d+(?:\.\d+)?)(?:\s*\u00d7\s*10([\u207b\u2070\u00b9\u00b2\u00b3\u2074-\u2079]+))?/.exec(text);
    if (!found) return NaN;
    const power = [...(found[2] || "")].map((c) => (c === "\u207b" ? "-" : RAISED.indexOf(c))).join("");
    return Number(found[1].replace("\u2212", "-") + (power && "e" + power));
  };
  const words = new Intl.Collator("en", { numeric: true });

  const setUp = (box) => {
    const table = box.querySelector("table"), body = table.tBodies[0];
    const rows = [...body.rows], heads = [...table.tHead.rows[0].cells];
    if (rows.length < SORTED_FROM) return;
    const name = document.getElementById(box.getAttribute("aria-labelledby")).querySelector("b").textContent.replace(".", "");
    const state = { column: -1, way: "none" };
    const show = () => {
      const { column, way } = state, sign = way === "descending" ? -1 : 1;
      const isNumber = column >= 0 && heads[column].classList.contains("number");
      const key = (row) => {
        const text = row.cells[column].textContent.trim();
        return isNumber ? number(text) : text === "\u2014" ? "" : text;
      };
      const isNothing = (value) => value === "" || Number.isNaN(value);
      const keyed = rows.map((row) => [way === "none" ? 0 : key(row), row]);
      if (way !== "none") {
        // What is no value stands last either way.
        keyed.sort(([a], [b]) => isNothing(a) - isNothing(b) || (isNothing(a) ? 0 : sign * (isNumber ? a - b : words.compare(a, b))));
      }
      body.append(...keyed.map(([, row]) => row));
      heads.forEach((head, at) => {
        if (at === column && way !== "none") head.setAttribute("aria-sort", way);
        else head.removeAttribute("aria-sort");
      });
    };
    heads.forEach((head, column) => {
      if (head.tagName !== "TH") return;
      const button = make("button", { type: "button", className: "sort" }, ...head.childNodes);
      button.addEventListener("click", () => {
        const next = state.column !== column ? "ascending" : { none: "ascending", ascending: "descending", descending: "none" }[state.way];
        Object.assign(state, { column, way: next });
        show();
        said.textContent = next === "none" ? `${name} in its own order` : `${name} sorted, ${next}, by ${button.textContent}`;
      });
      head.append(button);
    });
    const tools = make("p", { className: "tools" });
    if (box.classList.contains("stacks")) {
      const select = make("select", {}, make("option", { value: "-1" }, "its own order"));
      heads.forEach((head, at) => head.tagName === "TH" && select.append(make("option", { value: at }, head.textContent)));
      select.addEventListener("change", () => {
        Object.assign(state, { column: Number(select.value), way: Number(select.value) < 0 ? "none" : "ascending" });
        show();
      });
      tools.append(make("label", { className: "narrow" }, `Sort ${name.toLowerCase()} by `, select));
    }
    if (rows.length >= FILTERED_FROM) {
      const field = make("input", { type: "search", autocomplete: "off", spellcheck: false });
      const count = make("span", { className: "count" });
      field.addEventListener("input", () => {
        const wanted = field.value.trim().toLowerCase().split(/\s+/);
        rows.forEach((row) => {
          const text = [...row.cells].map((cell) => cell.textContent).join(" ").toLowerCase();
          row.hidden = !wanted.every((word) => text.includes(word));
        });
        count.textContent = field.value.trim() ? ` ${rows.filter((row) => !row.hidden).length} of ${rows.length} rows` : "";
        said.textContent = count.textContent;
      });
      tools.append(make("label", {}, `Filter ${name.toLowerCase()} `, field), count);
    }
    if (tools.childNodes.length) box.before(tools);
  };
  document.querySelectorAll("main .table").forEach(setUp);

  const tell = (box) => {
    const svg = box.querySelector("svg"), [, , wide] = svg.getAttribute("viewBox").split(" ").map(Number);
    const dot = make("span", { className: "dot", hidden: true }), tip = make("span", { className: "tip", hidden: true });
    [dot, tip].forEach((part) => part.setAttribute("aria-hidden", "true"));
    box.append(dot, tip);
    let places = null, titles = [], at = -1;
    const read = () => {
      if (places) return;
      const lines = box.dataset.values.split("\n");
      titles = lines.shift().split("\t");
      places = lines.map((line) => {
        const [place, ...cells] = line.split("\t"), [x, y] = place.split(" ").map(Number);
        return { x, y, cells };
      });
    };
    const hide = () => { dot.hidden = tip.hidden = true; };
    const show = (next) => {
      at = next;
      const { x, y, cells } = places[at], pairs = titles.map((title, i) => [title, cells[i]]).filter(([, cell]) => cell);
      tip.replaceChildren(...pairs.map(([title, cell]) => make("span", {}, title + ": ", make("b", {}, cell))));
      const outer = box.getBoundingClientRect(), inner = svg.getBoundingClientRect(), scale = inner.width / wide;
      const left = inner.left - outer.left - box.clientLeft + box.scrollLeft + x * scale, top = inner.top - outer.top - box.clientTop + y * scale;
      dot.hidden = tip.hidden = false;
      Object.assign(dot.style, { left: `${left}px`, top: `${top}px` });
      const room = box.clientWidth + box.scrollLeft - left, isRight = room > tip.offsetWidth + 16;
      const side = isRight ? left + 12 : Math.max(box.scrollLeft, left - 12 - tip.offsetWidth);
      const height = Math.max(0, Math.min(top - tip.offsetHeight / 2, box.clientHeight - tip.offsetHeight - 2));
      Object.assign(tip.style, { left: `${side}px`, top: `${height}px` });
      return pairs.map(([title, cell]) => `${title}: ${cell}`).join(", ");
    };
    const point = (event) => {
      read();
      const inner = svg.getBoundingClientRect(), scale = wide / inner.width;
      const [x, y] = [(event.clientX - inner.left) * scale, (event.clientY - inner.top) * scale];
      let best = -1, least = FAR * FAR;
      places.forEach((place, i) => {
        const square = (place.x - x) ** 2 + (place.y - y) ** 2;
        if (square < least) [best, least] = [i, square];
      });
      if (best < 0) hide();
      else if (best !== at || tip.hidden) show(best);
    };
    box.addEventListener("pointermove", point);
    box.addEventListener("pointerdown", point);
    box.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && hide());
    box.addEventListener("blur", hide);
    box.addEventListener("keydown", (event) => {
      read();
      const last = places.length - 1;
      const to = { ArrowRight: at + 1, ArrowLeft: at - 1, PageDown: at + 10, PageUp: at - 10, Home: 0, End: last }[event.key];
      if (event.key === "Escape") hide();
      if (to === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      said.textContent = show(Math.max(0, Math.min(last, to)));
      const x = parseFloat(dot.style.left);
      if (x < box.scrollLeft || x > box.scrollLeft + box.clientWidth) box.scrollLeft = x - box.clientWidth / 2;
    });
    box.tabIndex = 0;
    box.setAttribute("role", "group");
    const name = box.parentElement.querySelector("figcaption b").textContent.replace(".", "");
    box.setAttribute("aria-label", `${name}: arrow keys tell its values`);
  };
  document.querySelectorAll("main .drawing[data-values]").forEach(tell);
})();
