// Plain JavaScript. Charts are drawn beforehand, one variant for each metric, scale and axis, in <template>s; the script swaps
// them and reads values from their data-p attributes. All text goes in by textContent.
'use strict';
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const figure3 = v => !isFinite(v) ? String(v) : v === 0 ? '0'
  : Math.abs(v) >= 0.00995 && Math.abs(v) < 99999.5 ? String(Number(v.toPrecision(3))) : v.toExponential(2).replace('+', '');

// --- charts: which variant is shown ---
const chosen = {metric: '', scale: 'log', axis: 'time'};
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
    stage.replaceChildren();
    if (template) stage.append(template.content.cloneNode(true));
    else {
      const none = document.createElement('p');
      none.className = 'none';
      none.textContent = 'Nothing to draw for this choice.';
      stage.append(none);
    }
    hideTip(figure);
    applyHidden(figure);
  }
}
function showFormula() {
  const formula = document.querySelector('.toolbar [name=metric]').selectedOptions[0].dataset.formula;
  document.querySelector('.toolbar .formula').textContent = formula ? chosen.metric + ' = ' + formula + ' (x: image, r: reference)' : '';
}
for (const control of all('.toolbar [name]'))
  control.addEventListener('change', () => { chosen[control.name] = control.value; showFormula(); showVariants(); });

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
  const tip = figure.querySelector('.tip');
  if (tip) tip.replaceChildren();
  for (const cursor of all('.cursor', figure)) cursor.remove();
}
function showTip(svg, series, index) {
  const figure = svg.closest('figure');
  hideTip(figure);
  const [px, py, x, y, low, high] = series.points[index];
  const cursor = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
  for (const [name, value] of [['class', 'cursor'], ['r', 8], ['cx', px], ['cy', py]]) cursor.setAttribute(name, value);
  svg.append(cursor);
  let tip = figure.querySelector('.tip');
  if (!tip) {
    tip = document.createElement('div');
    tip.className = 'tip';
    tip.setAttribute('role', 'status');
    figure.append(tip);
  }
  const rows = svg.dataset.rows ? JSON.parse(svg.dataset.rows) : null;
  const title = document.createElement('b');
  title.textContent = (svg.dataset.title ? svg.dataset.title + ': ' : '') + (rows ? rows[y] : series.label);
  const lines = rows ? [series.label + ': ' + figure3(x) + unitOf(svg.dataset.x)]
    : [nameOf(svg.dataset.x) + ' ' + figure3(x) + unitOf(svg.dataset.x), nameOf(svg.dataset.y) + ' ' + figure3(y) + unitOf(svg.dataset.y)];
  if (!rows && high !== undefined) lines.push(figure3(low) + ' to ' + figure3(high));
  tip.append(title, ...lines.map(text => { const d = document.createElement('div'); d.textContent = text; return d; }));
  const at = new DOMPoint(px, py).matrixTransform(svg.getScreenCTM()), box = figure.getBoundingClientRect();
  const left = at.x - box.left + 14 + tip.offsetWidth > box.width ? at.x - box.left - 14 - tip.offsetWidth : at.x - box.left + 14;
  tip.style.left = Math.max(0, left) + 'px';
  tip.style.top = Math.max(0, at.y - box.top - tip.offsetHeight - 10) + 'px';
  svg.dataset.at = seriesOf(svg).indexOf(series) + ',' + index;
}
const unitOf = title => { const unit = /\[([^\]]*)\]/.exec(title); return unit ? ' ' + unit[1].replace(' per ray', '') : ''; };
const nameOf = title => title.split(/[,[]/)[0].trim();
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
    const filter = document.createElement('input');
    filter.type = 'search';
    filter.placeholder = 'filter rows';
    filter.setAttribute('aria-label', 'filter rows');
    filter.addEventListener('input', () => {
      const words = filter.value.toLowerCase().split(/\s+/);
      for (const row of body.rows) row.hidden = !words.every(word => row.textContent.toLowerCase().includes(word));
    });
    table.closest('figure').querySelector('figcaption').append(filter);
  }
}

// --- images ---
const scenes = JSON.parse(document.getElementById('images').textContent);
const uri = png => 'data:image/png;base64,' + png;
for (const viewer of all('.viewer')) {
  const {images, low, high, width} = scenes[Number(viewer.dataset.scene)];
  const part = name => viewer.querySelector('.' + name);
  const [left, right, exposure, zoom, wipe] = ['left', 'right', 'exposure', 'zoom', 'wipe'].map(part);
  const fill = select => images.forEach((image, i) => select.add(new Option(image.label, i)));
  fill(left);
  fill(right);
  // The one of least error against the reference, or the second image against the first.
  const known = images.map((image, i) => [image.relmse, i]).filter(([error]) => error !== null).sort((a, b) => a[0] - b[0]);
  left.value = known.length ? known[0][1] : images.length > 1 ? 1 : 0;
  right.value = 0;
  const show = () => {
    const a = images[left.value], b = images[right.value];
    part('over').src = uri(a.png);
    part('over').alt = a.label;
    part('under').src = uri(b.png);
    part('under').alt = b.label;
    part('name-left').textContent = '◀ ' + a.label + (a.detail ? ' (' + a.detail + ')' : '');
    part('name-right').textContent = b.label + (b.detail ? ' (' + b.detail + ')' : '') + ' ▶';
    const map = part('map'), mapped = a.err ? a : b.err ? b : null;
    map.hidden = !mapped;
    if (mapped) {
      part('error').src = uri(mapped.err);
      part('error').alt = 'error map of ' + mapped.label;
      part('name-map').textContent = 'Relative squared error of ' + mapped.label;
    }
    for (const button of all('.sheet button', viewer)) button.setAttribute('aria-pressed', String(button.value === left.value));
  };
  const scale = () => {
    for (const canvas of all('.canvas', viewer)) canvas.style.width = zoom.value === 'fit' ? '100%' : Number(zoom.value) * width + 'px';
  };
  const expose = () => {
    const slope = 2 ** Number(exposure.value);
    for (const f of all('filter *', viewer)) if (f.hasAttribute('slope')) f.setAttribute('slope', slope);
    part('ev').textContent = (exposure.value > 0 ? '+' : '') + exposure.value + ' EV';
    for (const image of all('.wipe-canvas img', viewer)) image.style.filter = slope === 1 ? '' : 'url(#' + viewer.querySelector('filter').id + ')';
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
  zoom.addEventListener('change', scale);
  exposure.addEventListener('input', expose);
  images.forEach((image, i) => {
    const button = document.createElement('button'), thumb = new Image(), name = document.createElement('span');
    button.type = 'button';
    button.value = i;
    thumb.src = uri(image.png);
    thumb.alt = '';
    name.textContent = image.label;
    button.append(thumb);
    if (image.err) {
      const map = new Image();
      map.src = uri(image.err);
      map.alt = 'error map';
      button.append(map);
    }
    button.append(name);
    if (image.relmse !== null) {
      const error = document.createElement('span');
      error.className = 'note';
      error.textContent = 'relmse ' + figure3(image.relmse);
      button.append(error);
    }
    button.addEventListener('click', () => { left.value = i; show(); });
    part('sheet').append(button);
  });
  for (let decade = low; decade <= high; ++decade) {
    const tick = document.createElement('span');
    tick.textContent = (decade === low ? '≤ ' : decade === high ? '≥ ' : '') + '1e' + decade;
    part('ticks').append(tick);
  }
  show();
  divide(50);
}

const metricSelect = document.querySelector('.toolbar [name=metric]');
if (metricSelect) {
  chosen.metric = metricSelect.value;
  // The browser may restore earlier choices on a reload.
  for (const control of all('.toolbar [name]:checked')) chosen[control.name] = control.value;
  showFormula();
  showVariants();
}
