// This is plain JavaScript. Charts are drawn beforehand, one variant for each metric, scale and axis, in <template>s; the script
// swaps them and reads values from their data-p attributes. All text goes in by textContent.
'use strict';
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const figure3 = v => !isFinite(v) ? String(v) : v === 0 ? '0'
  : Math.abs(v) >= 0.00995 && Math.abs(v) < 99999.5 ? String(Number(v.toPrecision(3))) : v.toExponential(2).replace('+', '');

// --- charts: which variant is shown ---
const chosen = {};
const hiddenKeys = new WeakMap();
function applyHidden(figure) {
  const hidden = hiddenKeys.get(figure) || new Set();
  for (const group of all('.series[data-key]', figure)) group.classList.toggle('hidden', hidden.has(group.dataset.key));
  for (const button of all('ul.legend button', figure)) button.setAttribute('aria-pressed', String(!hidden.has(button.dataset.key)));
}
function showVariants() {
  for (const figure of all('figure[data-uses]')) {
    const key = figure.dataset.uses.split(' ').map(name => chosen[name]).join('|');
    const template = all('template', figure).find(t => t.dataset.variant === key);
    const stage = figure.querySelector('.stage');
    if (stage.dataset.shown === key) continue;
    stage.dataset.shown = key;
    stage.replaceChildren(template ? template.content.cloneNode(true)
      : make('p', {className: 'none', textContent: 'Nothing to draw for this choice.'}));
    hideTip(figure);
    applyHidden(figure);
  }
}
const toolbar = document.querySelector('.toolbar');
function choose() {
  // The browser may restore earlier choices on a reload.
  for (const control of all('select, input:checked', toolbar)) chosen[control.name] = control.value;
  const {formula} = toolbar.querySelector('select').selectedOptions[0].dataset;
  toolbar.querySelector('.formula').textContent = formula ? chosen.metric + ' = ' + formula + ' (x: image, r: reference)' : '';
  showVariants();
}
toolbar.hidden = !toolbar.querySelector('option');
for (const input of all('[name=scale]', toolbar)) input.closest('fieldset').hidden = !document.querySelector('[data-variant*=linear]');
toolbar.addEventListener('change', choose);

// --- legends: a click switches a series, a double click shows it alone ---
document.addEventListener('click', event => {
  const button = event.target.closest('ul.legend button');
  if (!button) return;
  const figure = button.closest('figure');
  const keys = all('ul.legend button', figure).map(b => b.dataset.key);
  let hidden = hiddenKeys.get(figure) || new Set();
  const key = button.dataset.key;
  if (event.detail === 2 || event.shiftKey) {
    const alone = keys.every(k => k === key || hidden.has(k)) && event.shiftKey;
    hidden = new Set(alone ? [] : keys.filter(k => k !== key));
  } else if (event.detail < 3) {
    hidden.has(key) ? hidden.delete(key) : hidden.add(key);
    if (hidden.size === keys.length) hidden.clear();
  }
  hiddenKeys.set(figure, hidden);
  applyHidden(figure);
});

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
  const figureOf = (title, value) => figure3(value) + unitOf(title);
  const lines = rows ? [series.label + ': ' + figureOf(svg.dataset.x, x)]
    : [nameOf(svg.dataset.x) + ' ' + figureOf(svg.dataset.x, x), nameOf(svg.dataset.y) + ' ' + figureOf(svg.dataset.y, y)];
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
  i = Math.min(Math.max(i + step[1], 0), series[s].points.length - 1);
  showTip(svg, series[s], i);
});

// --- tables: sort by a click on a head, filter where there are many rows ---
for (const table of all('figure.table table')) {
  const body = table.tBodies[0], heads = all('thead th', table);
  heads.forEach((head, column) => head.firstElementChild.addEventListener('click', () => {
    const down = head.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
    for (const other of heads) other.removeAttribute('aria-sort');
    head.setAttribute('aria-sort', down > 0 ? 'ascending' : 'descending');
    const value = row => { const cell = row.cells[column]; return cell.dataset.v !== undefined ? Number(cell.dataset.v) : cell.textContent; };
    const numeric = head.classList.contains('num');
    body.append(...[...body.rows].sort((a, b) => {
      const x = value(a), y = value(b);
      if (numeric) {  // what was not measured stays below
        const p = typeof x === 'number', q = typeof y === 'number';
        return p && q ? down * (x - y) : Number(q) - Number(p);
      }
      return down * String(x).localeCompare(String(y), 'en', {numeric: true});
    }));
  }));
  if (body.rows.length > 15) {
    const filter = make('input', {type: 'search', placeholder: 'filter rows'});
    filter.setAttribute('aria-label', 'filter rows');
    filter.addEventListener('input', () => {
      const words = filter.value.toLowerCase().split(/\s+/);
      for (const row of body.rows) row.hidden = !words.every(word => row.textContent.toLowerCase().includes(word));
    });
    table.closest('figure').querySelector('figcaption').append(filter);
  }
}

// --- images ---
const {scenes, colours} = JSON.parse(document.getElementById('images').textContent);
const uri = png => 'data:image/png;base64,' + png;
for (const viewer of all('.viewer')) {
  const {images, low, high, width, notes} = scenes[viewer.dataset.scene];
  viewer.append(document.getElementById('viewer').content.cloneNode(true), ...notes.map(textContent => make('p', {className: 'note', textContent})));
  const part = name => viewer.querySelector('.' + name);
  const [left, right, exposure, zoom, wipe] = ['left', 'right', 'exposure', 'zoom', 'wipe'].map(part);
  const filter = viewer.querySelector('filter');
  filter.id = 'exposure-' + viewer.dataset.scene;
  part('colourbar').style.background = 'linear-gradient(to right,' + colours + ')';
  part('compared').hidden = images.filter(image => image.err).length < 2;
  for (const select of [left, right]) images.forEach((image, i) => select.add(new Option(image.label, i)));
  // The one of least error stands against the reference, or the second image against the first.
  const known = images.map((image, i) => [image.relmse, i]).filter(([error]) => error !== null).sort((a, b) => a[0] - b[0]);
  left.value = known.length ? known[0][1] : images.length > 1 ? 1 : 0;
  right.value = 0;
  const put = (name, png, alt) => Object.assign(part(name), {src: uri(png), alt});
  const named = image => image.label + (image.detail ? ' (' + image.detail + ')' : '');
  const show = () => {
    const a = images[left.value], b = images[right.value];
    put('over', a.png, a.label);
    put('under', b.png, b.label);
    part('name-left').textContent = '◀ ' + named(a);
    part('name-right').textContent = named(b) + ' ▶';
    const mapped = a.err ? a : b.err ? b : null;
    part('map').hidden = !mapped;
    if (mapped) {
      put('error', mapped.err, 'error map of ' + mapped.label);
      part('name-map').textContent = 'Relative squared error of ' + mapped.label;
    }
    for (const button of all('.sheet button', viewer)) button.setAttribute('aria-pressed', String(button.value === left.value));
  };
  const expose = () => {
    const slope = 2 ** Number(exposure.value);
    for (const f of all('[slope]', filter)) f.setAttribute('slope', slope);
    part('ev').textContent = (exposure.value > 0 ? '+' : '') + exposure.value + ' EV';
    for (const image of all('.wipe-canvas img', viewer)) image.style.filter = slope === 1 ? '' : 'url(#' + filter.id + ')';
  };
  const divide = percent => {
    wipe.value = percent;
    part('wipe-canvas').style.setProperty('--wipe', percent + '%');
  };
  const drag = event => {
    if (event.pointerType === 'mouse' && event.type === 'pointermove' && !event.buttons) return;
    const box = part('wipe-canvas').getBoundingClientRect();
    divide(Math.min(100, Math.max(0, 100 * (event.clientX - box.left) / box.width)));
  };
  part('wipe-canvas').addEventListener('pointermove', drag);
  part('wipe-canvas').addEventListener('pointerdown', drag);
  part('wipe-canvas').addEventListener('dragstart', event => event.preventDefault());
  wipe.addEventListener('input', () => divide(wipe.value));
  for (const select of [left, right]) select.addEventListener('change', show);
  zoom.addEventListener('change', () => {
    for (const canvas of all('.canvas', viewer)) canvas.style.width = zoom.value === 'fit' ? '100%' : zoom.value * width + 'px';
  });
  exposure.addEventListener('input', expose);
  images.forEach((image, value) => {
    const button = make('button', {type: 'button', value}, make('img', {src: uri(image.png), alt: ''}));
    if (image.err) button.append(make('img', {src: uri(image.err), alt: 'error map'}));
    button.append(make('span', {textContent: image.label}));
    if (image.relmse !== null) button.append(make('span', {className: 'note', textContent: 'relmse ' + figure3(image.relmse)}));
    button.addEventListener('click', () => { left.value = value; show(); });
    part('sheet').append(button);
  });
  for (let decade = low; decade <= high; ++decade)
    part('ticks').append(make('span', {textContent: (decade === low ? '≤ ' : decade === high ? '≥ ' : '') + '1e' + decade}));
  show();
  divide(50);
}

if (!toolbar.hidden) choose();
