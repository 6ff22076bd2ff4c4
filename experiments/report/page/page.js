// The page's script in plain JavaScript; the build embeds these files one after another: page, charts, tables, pixels, viewer,
// panes, start. Text goes in by textContent. This file holds what the others share: choices of the toolbar, and the view in
// the address.
'use strict';
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const figure3 = v => !isFinite(v) ? String(v) : v === 0 ? '0'
  : Math.abs(v) >= 0.00995 && Math.abs(v) < 99999.5 ? String(Number(v.toPrecision(3))) : v.toExponential(2).replace('+', '');
const count = v => Number.isInteger(v) && Math.abs(v) < 1e6 ? String(v) : figure3(v);  // of iterations, all digits
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

// --- the view in the address: "#metric=mse&view.0=…", beside plain links to sections ---
const view = {
  parameters: new URLSearchParams(location.hash.includes('=') ? location.hash.slice(1) : ''),
  pending: 0,
  // Values of null are removed. Sliders change often, and browsers forbid to write the address as often.
  write(changes) {
    for (const [name, value] of Object.entries(changes))
      value === null ? view.parameters.delete(name) : view.parameters.set(name, value);
    clearTimeout(view.pending);
    view.pending = setTimeout(() => {
      const text = view.parameters.toString().replaceAll('%3A', ':').replaceAll('%2C', ',');
      if (text || location.hash.includes('=')) history.replaceState(null, '', text ? '#' + text : location.pathname + location.search);
    }, 150);
  }
};
// A view that was typed is shown; a link to a section takes the view out of the address, where it is written again.
addEventListener('hashchange', () => location.hash.includes('=') ? location.reload() : view.write({}));

// --- the toolbar: what charts, tables and maps of error show ---
const chosen = {};
const onChoice = [];  // functions to call after each change
const toolbar = document.querySelector('.toolbar');
function choose() {
  for (const control of all('select, input:checked', toolbar)) chosen[control.name] = control.value;
  const {formula} = toolbar.querySelector('select').selectedOptions[0]?.dataset ?? {};
  toolbar.querySelector('.formula').textContent = formula ? chosen.metric + ' = ' + formula + ' (x: image, r: reference)' : '';
  for (const change of onChoice) change();
}
function restoreChoices() {
  const {parameters} = view;
  const select = toolbar.querySelector('select');
  if ([...select.options].some(option => option.value === parameters.get('metric'))) select.value = parameters.get('metric');
  for (const name of ['axis', 'scale'])
    for (const input of all('[name=' + name + ']', toolbar)) if (input.value === parameters.get(name)) input.checked = true;
}
toolbar.hidden = !toolbar.querySelector('option');
// Headings that links lead to lie below the toolbar, however many lines it takes.
new ResizeObserver(() => {
  const covered = getComputedStyle(toolbar).position === 'sticky' ? toolbar.offsetHeight : 0;
  document.documentElement.style.scrollPaddingTop = covered + 8 + 'px';
}).observe(toolbar);
for (const input of all('[name=scale]', toolbar))
  input.closest('fieldset').hidden = !document.querySelector('[data-variant*=linear]');
toolbar.addEventListener('change', event => {
  const first = event.target.matches('select') ? event.target.selectedIndex === 0 : event.target.defaultChecked;
  view.write({[event.target.name]: first ? null : event.target.value});
  choose();
});
