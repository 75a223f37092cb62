"""Opens every committed report in a headless Chromium.

    python3 .ci/pages.py [PAGE.html ...]

At widths of 390, 1280 and 1920 px: no error in the console, nothing asked of any server, no page wider than its window, no text
of a figure cut at its edge. At 1280 px axe-core finds no violation, on light and on dark; printed, every table and figure is there. Pictures and prints
are kept below target/pages. What cannot be had (the browser, axe-core) is skipped aloud.
"""

import concurrent.futures
import hashlib
import io
import os
import pathlib
import queue
import subprocess
import sys
import tarfile
import time

import browser

ROOT = pathlib.Path(__file__).resolve().parent.parent
KEPT = ROOT / "target" / "pages"
# More than these browsers at a time would wait for one another.
BROWSERS = min(2, os.cpu_count() or 1)
WIDTHS = {390: 844, 1280: 800, 1920: 1080}

# MPL-2.0; brought by npm when it is needed, and not part of the repository.
AXE = "axe-core@4.14.1"
AXE_SHA256 = "e6b0ce02b84d892e2e33e403485e7f3d6c29e2be6df65daf44d89ba564139745"
AXE_FILE = "package/axe.min.js"
# The rules of WCAG 2.2 at level AA, and what axe-core calls best practice.
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]

OVERFLOW = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
# Texts of figures that reach beyond the frame about the drawing, and by how many px. What is folded away is looked at too.
CUT = """(() => {
  const folded = [...document.querySelectorAll('main details:not([open])')];
  folded.forEach((part) => { part.open = true; });
  const cut = [...document.querySelectorAll('main figure svg')].flatMap((svg) => {
    const frame = svg.getBoundingClientRect();
    const room = parseFloat(getComputedStyle(svg.parentElement).paddingLeft) + 2;
    return [...svg.querySelectorAll('text')].flatMap((text) => {
      const box = text.getBoundingClientRect();
      const over = Math.max(frame.left - box.left, box.right - frame.right, frame.top - box.top, box.bottom - frame.bottom) - room;
      return box.width > 0 && over > 1 ? [`${svg.closest('figure').id}: ${text.textContent.trim()} (${over.toFixed(0)} px)`] : [];
    });
  });
  folded.forEach((part) => { part.open = false; });
  return cut;
})()"""
# Tables and figures that printing would leave out.
HIDDEN = """[...document.querySelectorAll('main table, main figure svg')].filter((part) => {
  const box = part.getBoundingClientRect();
  return box.width === 0 || box.height === 0 || !part.checkVisibility({contentVisibilityAuto: true});
}).map((part) => (part.closest('figure') || part.closest('.table') || part).id || part.outerHTML.slice(0, 80))"""
RUN_AXE = """axe.run(document, {resultTypes: ['violations'], preload: false, runOnly: %s}).then((found) =>
  found.violations.map((one) => `${one.id} (${one.impact}): ${one.help}; ${one.nodes.length} places, first `
    + `${one.nodes[0].target.join(' ')}: ${(one.nodes[0].any[0] || one.nodes[0].all[0] || one.nodes[0].none[0] || {}).message}`))"""


def axe():
    """The text of axe-core, from target/ or brought by npm; None where it cannot be had."""
    place = ROOT / "target" / (AXE.replace("@", "-") + ".tgz")
    if not place.is_file():
        command = ["npm", "pack", AXE, "--silent", "--pack-destination", str(place.parent)]
        try:
            subprocess.run(command, check=True, timeout=120, stdout=subprocess.DEVNULL)
        except (OSError, subprocess.SubprocessError) as error:
            print(f"SKIPPED: npm does not bring {AXE} here ({error}), so pages were not checked with it")
            return None
    packed = place.read_bytes()
    if (own := hashlib.sha256(packed).hexdigest()) != AXE_SHA256:
        sys.exit(f"{place} has the hash {own}, expected {AXE_SHA256}")
    with tarfile.open(fileobj=io.BytesIO(packed)) as files:
        return files.extractfile(AXE_FILE).read().decode()


def pages():
    """The committed pages."""
    listed = subprocess.run(["git", "ls-files", "reports"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.split("\n") if name.endswith(".html")]


def complaints(events):
    """What the browser held against a page, and what the page asked for beside itself."""
    for event in events:
        said = event["params"]
        if event["method"] == "Runtime.exceptionThrown":
            yield f"an exception: {said['exceptionDetails']['text']}"
        elif event["method"] == "Runtime.consoleAPICalled" and said["type"] in ("error", "warning", "assert"):
            yield f"the console: {said['args'][0].get('value')}"
        elif event["method"] == "Log.entryAdded" and said["entry"]["level"] in ("error", "warning"):
            yield f"the console: {said['entry']['text']}"
        elif event["method"] == "Network.requestWillBeSent" and said["type"] != "Document":
            yield f"a request: {said['request']['url'][:200]}"


def check(own, page, script):
    """What is wrong with a page."""
    name = "-".join(page.relative_to(ROOT).with_suffix("").parts if page.is_relative_to(ROOT) else page.parts[-3:])
    wrong = []
    own.media()
    for width, height in WIDTHS.items():
        own.size(width, height)
        if width == min(WIDTHS):
            own.open(page.as_uri())
            wrong += complaints(own.recent_events())
        if (over := own.evaluate(OVERFLOW)) > 0:
            wrong.append(f"at {width} px it is {over} px too wide")
        wrong += [f"at {width} px a text is cut: {text}" for text in own.evaluate(CUT)]
        own.picture(KEPT / f"{name}-{width}.png")
    own.size(1280, WIDTHS[1280])
    if script:
        own.evaluate(f"{script};0")
        wrong += own.evaluate(RUN_AXE % RULES, 120)
    own.media(scheme="dark")
    own.picture(KEPT / f"{name}-dark.png")
    if script:
        wrong += [f"on dark: {one}" for one in own.evaluate(RUN_AXE % ["color-contrast"], 120)]
    own.media("print")
    wrong += [f"not printed: {part}" for part in own.evaluate(HIDDEN)]
    own.media()
    own.printed(KEPT / f"{name}.pdf")
    return wrong + [f"later, {one}" for one in complaints(own.recent_events())]


def main():
    program = browser.find()
    if not program:
        print("SKIPPED: there is no Chromium on the PATH (Debian: apt install chromium), so no page was opened")
        return
    KEPT.mkdir(parents=True, exist_ok=True)
    script, begun, failed = axe(), time.monotonic(), 0
    all_pages = [pathlib.Path(name).resolve() for name in sys.argv[1:]] or pages()
    browsers, free = [], queue.SimpleQueue()

    def checked(page):
        own = free.get()
        try:
            return page, check(own, page, script)
        except browser.Failed as error:
            return page, [f"the browser: {error}"]
        finally:
            free.put(own)

    try:
        for _ in range(BROWSERS):
            browsers.append(browser.Browser(program))
            free.put(browsers[-1])
        with concurrent.futures.ThreadPoolExecutor(BROWSERS) as pool:
            for page, wrong in pool.map(checked, all_pages):
                failed += bool(wrong)
                for line in wrong:
                    print(f"{os.path.relpath(page, ROOT)}: {line}")
    finally:
        for own in browsers:
            own.close()
    print(f"{len(all_pages)} pages in {time.monotonic() - begun:.0f} s, {failed} with something wrong; pictures in target/pages")
    if failed or not all_pages:
        sys.exit(1)


if __name__ == "__main__":
    main()
