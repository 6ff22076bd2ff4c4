// Tables: a click on a head sorts, chips fold groups of columns, the columns of names stay in sight, and where there are many rows
// they can be filtered.

function sortBy(head) {
  const table = head.closest('table'), body = table.tBodies[0], heads = all('thead th', table), column = heads.indexOf(head);
  const down = head.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
  for (const other of heads) other.removeAttribute('aria-sort');
  head.setAttribute('aria-sort', down > 0 ? 'ascending' : 'descending');
  const value = row => {
    const cell = row.cells[column];
    return cell.dataset.v !== undefined ? Number(cell.dataset.v) : cell.textContent;
  };
  const numeric = head.classList.contains('num');
  body.append(...[...body.rows].sort((a, b) => {
    const x = value(a), y = value(b);
    if (numeric) {  // what was not measured stays below
      const p = typeof x === 'number', q = typeof y === 'number';
      return p && q ? down * (x - y) : Number(q) - Number(p);
    }
    return down * String(x).localeCompare(String(y), 'en', {numeric: true});
  }));
}
document.addEventListener('click', event => {
  const head = event.target.closest('figure table th button');
  if (head) sortBy(head.closest('th'));
  const chip = event.target.closest('.chips button');
  if (chip) {
    const figure = chip.closest('figure'), folded = figure.classList.toggle('fold' + chip.value);
    chip.setAttribute('aria-pressed', String(!folded));
    freeze(figure);
    figure.querySelector('input[type=search]')?.dispatchEvent(new Event('input'));
  }
});

// Names stay in sight while figures scroll: as many of the leading columns as leave room, and the first in any case.
function freeze(figure) {
  const scroll = figure.querySelector('.scroll'), table = figure.querySelector('table');
  if (!scroll || !table) return;
  const heads = all('thead th', table);
  for (const cell of all('.frozen', table)) {
    cell.classList.remove('frozen');
    cell.style.left = '';
  }
  if (table.scrollWidth <= scroll.clientWidth) return;
  let left = 0;
  for (let column = 0; column < heads.length && heads[column].classList.contains('names'); ++column) {
    const width = heads[column].offsetWidth;
    if (column > 0 && left + width > 0.5 * scroll.clientWidth) break;
    for (const row of table.rows) {
      row.cells[column].classList.add('frozen');
      row.cells[column].style.left = left + 'px';
    }
    left += width;
  }
}
const tableFigures = all('figure.table');
addEventListener('resize', () => tableFigures.forEach(freeze));
onChoice.push(() => all('figure.table[data-uses]').forEach(freeze));

function addFilter(figure) {
  const body = figure.querySelector('tbody'), heads = all('thead th', figure);
  const filter = make('input', {type: 'search', placeholder: 'filter rows'});
  filter.setAttribute('aria-label', 'filter rows');
  filter.addEventListener('input', () => {
    const words = filter.value.toLowerCase().split(/\s+/);
    for (const row of body.rows) {  // cells of folded columns are out of sight
      const texts = [...row.cells].filter((_, column) => heads[column].offsetWidth > 0).map(cell => cell.textContent.toLowerCase());
      row.hidden = !words.every(word => texts.some(text => text.includes(word)));
    }
  });
  figure.querySelector('figcaption').append(filter);
}
const mostUnfilteredRows = 15;
for (const figure of tableFigures)
  if (!figure.dataset.uses && figure.querySelector('tbody')?.rows.length > mostUnfilteredRows) addFilter(figure);
