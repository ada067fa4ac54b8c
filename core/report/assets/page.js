// Legends switch their series; curves are read under the pointer or by the arrow keys. The page is whole without.
(() => {
  const all = (at, what) => [...at.querySelectorAll(what)];
  const number = v => String(+v.toPrecision(4)).replace('-', '\u2212');
  const box = document.createElement('output');
  box.className = 'value'; box.hidden = true; document.body.append(box);
  for (const figure of all(document, 'figure')) {
    for (const key of all(figure, '.legend span')) {
      const color = key.dataset.color, within = key.closest('.tile') || figure;
      key.tabIndex = 0; key.setAttribute('role', 'button'); key.setAttribute('aria-pressed', 'true');
      key.onclick = () => {
        const off = key.classList.toggle('off');
        key.setAttribute('aria-pressed', !off);
        all(within, `.plot [stroke="${color}"],.plot [fill="${color}"]`).forEach(m => m.style.display = off ? 'none' : '');
      };
      key.onkeydown = e => { if (e.key === ' ' || e.key === 'Enter') { e.preventDefault(); key.click(); } };
    }
    for (const svg of all(figure, 'svg[data-plot]')) read(figure, svg, JSON.parse(svg.dataset.plot));
  }
  function read(figure, svg, plots) {
    const view = svg.viewBox.baseVal, tile = svg.closest('.tile');
    const named = {};
    for (const key of [...all(figure, ':scope > .legend span'), ...all(tile, '.legend span')]) named[key.dataset.color] = key.textContent;
    const below = all(svg.closest('.tiles'), 'svg[data-plot]').flatMap(s => JSON.parse(s.dataset.plot)).map(p => p.names[0]).pop();
    const mark = document.createElementNS(svg.namespaceURI, 'circle');
    mark.setAttribute('r', 22); mark.setAttribute('class', 'mark'); mark.setAttribute('fill', 'none');
    mark.setAttribute('stroke', 'currentColor'); mark.setAttribute('stroke-width', 8);
    let at;
    const hide = () => { box.hidden = true; mark.remove(); };
    const show = () => {
      const [x, y] = at;
      const plot = plots.find(({at: [l, t, w, h]}) => x >= l && x <= l + w && y >= t && y <= t + h);
      if (!plot) return hide();
      const [l, t, w, h] = plot.at, best = {};
      for (const m of all(svg, 'polyline,circle:not(.mark)')) {
        const color = m.tagName === 'circle' && m.getAttribute('fill') !== 'none' ? m.getAttribute('fill') : m.getAttribute('stroke');
        if (m.style.display || color === '#787E86') continue;
        const group = named[color] ? color : '', p = m.points;
        for (let i = 0; i < (p ? p.length : 1); i++) {
          let [a, b] = p ? [p[i].x, p[i].y] : [m.cx.baseVal.value, m.cy.baseVal.value];
          const n = p && p[i + 1];
          if (n && n.x > a && x > a && x < n.x) { b += (n.y - b) * (x - a) / (n.x - a); a = x; }
          const far = Math.hypot(a - x, b - y), line = Math.abs(a - x);
          const old = best[group];
          if (!old || far < old.far) best[group] = { a, b, far, line };
        }
      }
      const found = Object.entries(best).sort(([, p], [, q]) => p.far - q.far);
      if (!found.length) return hide();
      const near = found[0][1], close = found.filter(([, p]) => Math.abs(p.a - near.a) < 3);
      mark.setAttribute('cx', near.a); mark.setAttribute('cy', near.b); svg.append(mark);
      const abscissa = plot.x[0] + (near.a - l) / w * (plot.x[1] - plot.x[0]);
      const ordinate = b => number(plot.y[1] - (b - t) / h * (plot.y[1] - plot.y[0]));
      box.textContent = [`${plot.names[0] || below}: ${number(abscissa)}`,
        ...close.map(([c, p]) => `${c ? named[c] + ', ' : ''}${plot.names[1]}: ${ordinate(p.b)}`)].join('\n');
      box.hidden = false;
      const r = svg.getBoundingClientRect(), s = r.width / view.width;
      box.style.left = Math.max(8, Math.min(r.left + near.a * s + 14, innerWidth - box.offsetWidth - 8)) + 'px';
      box.style.top = Math.max(8, Math.min(r.top + near.b * s + 14, innerHeight - box.offsetHeight - 8)) + 'px';
    };
    svg.onpointermove = svg.onpointerdown = e => {
      const r = svg.getBoundingClientRect();
      at = [(e.clientX - r.left) * view.width / r.width, (e.clientY - r.top) * view.height / r.height];
      show();
    };
    svg.onpointerleave = svg.onblur = hide;
    svg.tabIndex = 0;
    svg.onkeydown = e => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
      if (e.key === 'Escape') return hide();
      if (!step) return;
      e.preventDefault();
      const [l, t, w, h] = plots[0].at;
      at = at || [l, t + h / 2];
      at = [Math.max(l, Math.min(l + w, at[0] + step[0] * w / 60)), Math.max(t, Math.min(t + h, at[1] + step[1] * h / 30))];
      show();
    };
  }
})();
