// Charts are drawn beforehand, one variant for each metric, scale and axis, as text of scripts that no browser runs; this one
// swaps them, draws small multiples from them, switches series, and reads values from their data-p attributes.

// --- which variant is shown ---
function showVariants() {
  for (const figure of all('figure[data-uses]')) {
    const key = figure.dataset.uses.split(' ').map(name => chosen[name]).join('|');
    const stage = figure.querySelector('.stage');
    if (stage.dataset.shown === key) continue;
    const variant = all('script[data-variant]', figure).find(script => script.dataset.variant === key);
    stage.dataset.shown = key;
    stage.innerHTML = variant ? variant.textContent : '<p class="none">Nothing to draw for this choice.</p>';
    hideTip(figure);
    drawMultiples(figure);
  }
  applyHidden();
}
onChoice.push(showVariants);

// --- small multiples: the same chart once for each method, the others grey behind it ---
// A key names integrator and structure, "i2a0", and a label does, "sppm · sah". Of one integrator, each structure is a method.
const mostMultiples = 24;
function drawMultiples(figure) {
  const place = figure.querySelector('.multiples'), svg = figure.querySelector('.stage svg.chart');
  if (!place) return;
  place.replaceChildren();
  const keys = svg ? [...new Set(all('.series[data-key^=i]', svg).map(series => series.dataset.key))] : [];
  const several = new Set(keys.map(key => key.split('a')[0])).size > 1;
  const groupOf = key => several ? key.split('a')[0] : key, groups = [...new Set(keys.map(groupOf))];
  const lines = svg ? all('.series[data-key^=i] > .line', svg) : [];  // of single points there is nothing to follow
  if (groups.length < 2 || groups.length > mostMultiples || !lines.length) return;
  for (const group of groups) {
    const copy = svg.cloneNode(true), plot = copy.querySelector('svg.plot');
    const own = all('.series', copy).filter(series => groupOf(series.dataset.key) === group);
    const name = own.length > 1 ? own[0].dataset.label.split(' · ')[0] : own[0].dataset.label;
    copy.removeAttribute('tabindex');
    copy.setAttribute('aria-label', name + ': ' + svg.getAttribute('aria-label'));
    for (const text of all('.axis-title, .label, .leader', copy)) text.remove();
    // On logarithmic axes there is room for decades alone, where two of them are named; on linear ones one zero is enough.
    const ticks = all('text[text-anchor=middle]', copy), within = ticks.filter(tick => /^(0\.0*)?[25](0*|·.*)$/.test(tick.textContent));
    const isZero = tick => Number(tick.textContent) === 0, zero = ticks.find(isZero), levels = all('text[text-anchor=end]', copy);
    if (ticks.length > within.length + 1 && !zero) for (const tick of within) tick.remove();
    if (zero && levels.length && isZero(levels[0])) zero.remove();
    for (const series of all('.series', copy)) {
      if (own.includes(series)) continue;
      series.setAttribute('class', 'context');
      for (const part of all('.mark, .band', series)) part.remove();
      delete series.dataset.p;
      plot.prepend(series);
    }
    place.append(make('div', {className: 'multiple'}, make('div', {className: 'panel-name', textContent: name}), copy));
  }
}

// --- legends: a click switches a series everywhere on the page, a double click shows it alone, a second one all again ---
const hidden = new Set();
function applyHidden() {
  for (const series of all('g[data-key]')) series.classList.toggle('hidden', hidden.has(series.dataset.key));
  for (const multiple of all('.multiple')) multiple.hidden = all('.series', multiple).every(series => hidden.has(series.dataset.key));
  for (const button of all('ul.legend button')) button.setAttribute('aria-pressed', String(!hidden.has(button.dataset.key)));
}
const keysOf = figure => [...new Set(all('ul.legend button', figure).map(b => b.dataset.key))];
function toggle(key, keys) {
  hidden.has(key) ? hidden.delete(key) : hidden.add(key);
  if (keys.every(k => hidden.has(k))) for (const k of keys) hidden.delete(k);
}
function isolate(key, keys, wasAlone) {
  for (const k of keys) k === key || wasAlone ? hidden.delete(k) : hidden.add(k);
}
let beforeClick = {};  // a double click is two clicks as well: what the series were before the first
document.addEventListener('click', event => {
  const button = event.target.closest('ul.legend button');
  if (!button) return;
  const keys = keysOf(button.closest('figure')), key = button.dataset.key;
  const isAlone = () => keys.every(k => (k === key) !== hidden.has(k));
  if (event.shiftKey) {
    isolate(key, keys, isAlone());
  } else if (event.detail < 2) {
    beforeClick = {key, wasAlone: isAlone()};
    toggle(key, keys);
  } else if (event.detail === 2) {
    isolate(key, keys, beforeClick.key === key && beforeClick.wasAlone);
  }
  applyHidden();
});
function emphasize(key) {
  document.body.classList.toggle('hovering', key !== undefined);
  for (const series of all('.series[data-key]')) series.classList.toggle('hot', key !== undefined && series.dataset.key === key);
}
for (const [on, off] of [['pointerover', 'pointerout'], ['focusin', 'focusout']]) {
  const button = event => event.target.closest && event.target.closest('ul.legend button');
  document.addEventListener(on, event => button(event) && emphasize(button(event).dataset.key));
  document.addEventListener(off, event => button(event) && emphasize(undefined));
}

// --- read-outs ---
const parsed = new WeakMap();
function seriesOf(svg) {
  if (!parsed.has(svg))
    parsed.set(svg, all('.series[data-p]', svg).filter(g => g.dataset.p && !g.classList.contains('stairs')).map(group => ({
      group, label: group.dataset.label, points: group.dataset.p.split(';').map(p => p.split(',').map(Number))})));
  return parsed.get(svg).filter(s => !s.group.classList.contains('hidden'));
}
function hideTip(figure) {
  for (const tip of all('.tip', figure)) tip.replaceChildren();
  for (const cursor of all('.cursor', figure)) cursor.remove();
}
const unitOf = title => { const unit = /\[([^\]]*)\]/.exec(title); return unit ? ' ' + unit[1].replace(' per ray', '') : ''; };
const nameOf = title => title.split(/[,[]/)[0].trim();
function showTip(svg, series, index) {
  const figure = svg.closest('figure');
  hideTip(figure);
  const [px, py, x, y, low, high] = series.points[index];
  const cursor = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
  for (const [name, value] of [['class', 'cursor'], ['r', 8], ['cx', px], ['cy', py]]) cursor.setAttribute(name, value);
  svg.append(cursor);
  const rows = svg.dataset.rows && JSON.parse(svg.dataset.rows);
  const across = count(x) + unitOf(svg.dataset.x);
  const lines = rows ? [series.label + ': ' + across]
    : [nameOf(svg.dataset.x) + ' ' + across, nameOf(svg.dataset.y) + ' ' + figure3(y) + unitOf(svg.dataset.y)];
  if (!rows && high !== undefined) lines.push(figure3(low) + ' to ' + figure3(high));
  const title = (svg.dataset.title ? svg.dataset.title + ': ' : '') + (rows ? rows[y] : series.label);
  const tip = figure.querySelector('.tip') || figure.appendChild(make('div', {className: 'tip'}));
  tip.setAttribute('role', 'status');
  tip.append(make('b', {textContent: title}), ...lines.map(textContent => make('div', {textContent})));
  const at = new DOMPoint(px, py).matrixTransform(svg.getScreenCTM()), box = figure.getBoundingClientRect();
  const left = at.x - box.left + 14 + tip.offsetWidth > box.width ? at.x - box.left - 14 - tip.offsetWidth : at.x - box.left + 14;
  tip.style.left = Math.max(0, left) + 'px';
  tip.style.top = Math.max(0, at.y - box.top - tip.offsetHeight - 10) + 'px';
  svg.dataset.at = seriesOf(svg).indexOf(series) + ',' + index;
}
function pointAt(event) {
  const svg = event.target.closest && event.target.closest('svg.chart');
  if (!svg) return;
  const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  let best = null, nearest = 70 * 70;
  for (const series of seriesOf(svg))
    series.points.forEach(([px, py], index) => {
      const d = (px - at.x) ** 2 + (py - at.y) ** 2;
      if (d < nearest) { nearest = d; best = [series, index]; }
    });
  if (best) showTip(svg, ...best); else hideTip(svg.closest('figure'));
}
document.addEventListener('pointermove', pointAt);
document.addEventListener('pointerdown', pointAt);
document.addEventListener('pointerout', event => {
  const svg = event.target.closest && event.target.closest('svg.chart');
  if (svg && !(event.relatedTarget && svg.contains(event.relatedTarget))) hideTip(svg.closest('figure'));
});
document.addEventListener('focusout', event => {
  if (event.target.matches && event.target.matches('svg.chart')) hideTip(event.target.closest('figure'));
});
document.addEventListener('keydown', event => {
  const svg = event.target;
  if (!(svg.matches && svg.matches('svg.chart'))) return;
  if (event.key === 'Escape') return hideTip(svg.closest('figure'));
  const step = {ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0]}[event.key];
  const series = seriesOf(svg);
  if (!step || !series.length) return;
  event.preventDefault();
  let [s, i] = (svg.dataset.at || '0,0').split(',').map(Number);
  s = (Math.max(0, s) + step[0] + series.length) % series.length;
  i = clamp(i + step[1], 0, series[s].points.length - 1);
  showTip(svg, series[s], i);
});
