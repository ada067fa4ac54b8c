"""Pages of the program in Chromium, on a phone and on a desk, white and black, with and without their script.

Makes pages with the verbs that take seconds, opens each, and fails on what a reader would stumble over: text that is cut
off, overlaps, is small or pale; a page that scrolls sideways; too many curves in one figure; a script without effect."""

import pathlib
import shutil
import subprocess
import sys

try:
    from playwright.sync_api import sync_playwright
except ImportError:
    print("skipped: report_pages_peer: no playwright")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = str(ROOT / "meshes/tpu80/scene-typical.toml")
WIDTHS = [380, 1400]
SMALLEST_TYPE_PX = 12
LOWEST_CONTRAST = 4.5
MAX_CURVES = 12

# Folder of the page, and the command that makes it.
PAGES = [
    ("rec", ["record", "--rig", "virtual:typical", "--plan", "quick", "--out", "rec"]),
    ("simulated", ["simulate", SCENE, "--strokes", "rec/ellipse.parquet", "--out", "tip.parquet", "--figures", "simulated"]),
    ("identified", ["identify", SCENE, "rec/ellipse.parquet", "--out", "identified"]),
    ("target", ["target", "circle:20", "--scene", SCENE, "--out", "target.parquet", "--figures", "target"]),
    ("commands", ["command", "--scene", SCENE, "--target", "circle:20", "--out", "strokes.parquet", "--figures", "commands"]),
    (None, ["record", "--rig", "virtual:typical", "--strokes", "strokes.parquet", "--out", "tracked.parquet"]),
    ("evaluated", ["evaluate", "--target", "circle:20", "tracked.parquet", "--out", "evaluated"]),
    ("generated", ["generate", SCENE, "--plan", "quick", "--out", "generated"]),
    ("excited", ["arm", "excite", "open-manipulator-x", "--out", "motion.parquet", "--figures", "excited"]),
]

# What is wrong with a page as it is shown now, as a list of sentences.
LOOK = """
({smallest, contrast, maxCurves}) => {
  const wrong = [], say = (what, node) => wrong.push(`${what}: ${(node.textContent || node.tagName).trim().slice(0, 60)}`);
  document.querySelectorAll('details').forEach(d => d.open = true);
  const seen = e => e.checkVisibility() && e.getBoundingClientRect().width > 0;
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width) say('the page scrolls sideways', document.body);
  const first = document.querySelector('h1').nextElementSibling;
  if (!first.matches('.verdict')) say('no verdict first', first);
  const rgb = text => text.match(/[\\d.]+/g).map(Number);
  const light = c => c.slice(0, 3).map(v => v / 255).map(v => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [.2126, .7152, .0722][k], 0);
  const ratio = (a, b) => { const [p, q] = [light(a), light(b)]; return (Math.max(p, q) + .05) / (Math.min(p, q) + .05); };
  const paper = node => {
    for (let at = node; at; at = at.parentElement) {
      const color = rgb(getComputedStyle(at).backgroundColor);
      if (color.length === 3 || color[3] > 0) return color;
    }
    return [255, 255, 255];
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const boxes = new Map();
  while (walker.nextNode()) {
    const node = walker.currentNode, parent = node.parentElement;
    if (!node.textContent.trim() || parent.closest('script,style') || !seen(parent)) continue;
    const style = getComputedStyle(parent), svg = parent.closest('svg');
    const range = document.createRange();
    range.selectNodeContents(node);
    const rects = svg ? [parent.getBoundingClientRect()] : [...range.getClientRects()];
    const scale = svg ? svg.getBoundingClientRect().width / svg.viewBox.baseVal.width : 1;
    if (parseFloat(style.fontSize) * scale < smallest) say(`type of ${parseFloat(style.fontSize) * scale} px`, node);
    const ink = rgb(svg ? style.fill : style.color);
    const below = svg ? rgb(getComputedStyle(svg.querySelector('rect')).fill) : paper(parent);
    if (ratio(ink, below) < contrast) say(`contrast ${ratio(ink, below).toFixed(1)}`, node);
    for (const r of rects) {
      if (r.right > width + 1 || r.left < -1) say('beyond the window', node);
      for (let at = parent; at; at = at.parentElement) {
        const clips = getComputedStyle(at).overflowX !== 'visible' || at === svg;
        const b = at.getBoundingClientRect();
        if (clips && at !== document.documentElement && at !== document.body &&
          (r.left < b.left - 1 || r.right > b.right + 1 || r.top < b.top - 1 || r.bottom > b.bottom + 1)) say(`cut off by ${at.tagName}`, node);
      }
      if (svg) {
        const others = boxes.get(svg) || [];
        for (const [o, text] of others) {
          const across = Math.min(r.right, o.right) - Math.max(r.left, o.left);
          const down = Math.min(r.bottom, o.bottom) - Math.max(r.top, o.top);
          // Boxes hold the line's height, of which letters fill two thirds.
          if (across > 1 && down > .3 * Math.min(r.height, o.height)) say(`overlaps ${text}`, node);
        }
        others.push([r, node.textContent.trim()]);
        boxes.set(svg, others);
      }
    }
  }
  for (const e of document.querySelectorAll('.scroll,.tiles,.tile,pre')) {
    if (seen(e) && e.scrollWidth > e.clientWidth + 1) say('scrolls sideways', e);
  }
  for (const svg of document.querySelectorAll('svg.plot')) {
    const keys = [...svg.closest('figure').querySelectorAll(':scope > .legend span'), ...svg.closest('.tile').querySelectorAll('.legend span')];
    const drawn = keys.filter(k => svg.querySelector(`polyline[stroke="${k.dataset.color}"]`));
    if (drawn.length > maxCurves) say(`${drawn.length} curves in one figure`, svg);
    if (new Set(drawn.map(k => k.dataset.color)).size < drawn.length) say('two curves of one colour', svg);
  }
  return wrong;
}
"""

# What does not react as it should, with the script.
USE = """
() => {
  const wrong = [], box = document.querySelector('.value');
  const seen = e => e.checkVisibility() && e.getBoundingClientRect().width > 0;
  for (const svg of [...document.querySelectorAll('svg[data-plot]')].filter(seen)) {
    const r = svg.getBoundingClientRect(), v = svg.viewBox.baseVal;
    const [l, t, w, h] = JSON.parse(svg.dataset.plot)[0].at;
    const at = {clientX: r.left + (l + w / 2) * r.width / v.width, clientY: r.top + (t + h / 2) * r.height / v.height};
    const drawn = svg.querySelector('polyline:not([stroke="#787E86"]),circle');
    svg.dispatchEvent(new PointerEvent('pointermove', at));
    if (drawn && (box.hidden || !/: [\\u22120-9]/.test(box.textContent))) wrong.push('no value under the pointer: ' + svg.closest('figure').textContent.slice(0, 40));
    svg.dispatchEvent(new PointerEvent('pointerleave'));
    if (!box.hidden) wrong.push('a value without a pointer');
    svg.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight'}));
    if (drawn && box.hidden) wrong.push('no value by the keyboard');
    svg.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}));
  }
  for (const key of document.querySelectorAll('.legend span')) {
    const within = key.closest('.tile') || key.closest('figure'), color = key.dataset.color;
    const marks = [...within.querySelectorAll(`.plot [stroke="${color}"],.plot [fill="${color}"]`)];
    if (!marks.length) wrong.push('a legend of nothing: ' + key.textContent);
    key.dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter'}));
    if (marks.some(m => getComputedStyle(m).display !== 'none') || key.getAttribute('aria-pressed') !== 'false') wrong.push('not switched off: ' + key.textContent);
    key.click();
    if (marks.some(m => m.style.display) || key.getAttribute('aria-pressed') !== 'true') wrong.push('not switched on: ' + key.textContent);
  }
  return wrong;
}
"""


def made(program, folder):
    """Pages that the program makes, and the one with every block at its limits."""
    for name, arguments in PAGES:
        done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(arguments)}: {done.stderr[-800:]}")
        if name is not None:
            yield name, folder / name / "report.html"
    example = program.parent / "examples" / "blocks"
    if example.exists():
        subprocess.run([example, folder / "blocks"], check=True)
        yield "blocks", folder / "blocks/report.html"


def faults(browser, path, width, scheme, with_script, picture):
    """What is wrong with a page in a window."""
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme, java_script_enabled=True
    )
    page = context.new_page()
    found = []
    page.on("request", lambda it: None if it.url.startswith("file:") else found.append(f"asks for {it.url}"))
    page.on("pageerror", lambda error: found.append(f"script: {error}"))
    if not with_script:
        # As where scripts are switched off; Chromium then evaluates none of ours either.
        page.route("**/report.html", lambda it: it.fulfill(body=without_script(path), content_type="text/html"))
    page.goto(path.as_uri())
    found += page.evaluate(LOOK, {"smallest": SMALLEST_TYPE_PX, "contrast": LOWEST_CONTRAST, "maxCurves": MAX_CURVES})
    if with_script:
        found += page.evaluate(USE)
        page.screenshot(path=picture, full_page=True)
    context.close()
    return found


def without_script(path):
    before, after = path.read_text().split("<script>")
    return before + after.split("</script>")[1]


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"]
    chromium = next((path for path in map(shutil.which, names) if path), None)
    if chromium is None:
        print("skipped: report_pages_peer: no Chromium on the path")
        sys.exit(77)
    n_faults = n_views = 0
    pages = list(made(program, folder))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for name, path in pages:
            for width in WIDTHS:
                for scheme, with_script in [("light", True), ("dark", True), ("light", False)]:
                    picture = folder / f"{name}-{width}-{scheme}.png"
                    found = faults(browser, path, width, scheme, with_script, picture)
                    n_views += 1
                    n_faults += len(found)
                    for fault in sorted(set(found)):
                        print(f"{name}, {width} px, {scheme}, {'with' if with_script else 'without'} script: {fault}")
        browser.close()
    print(f"report_pages: {len(pages)} pages, {n_views} views, {n_faults} faults")
    sys.exit(1 if n_faults else 0)


if __name__ == "__main__":
    main()
