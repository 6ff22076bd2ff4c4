// Starts the page: choices as the address has them and charts at once, then viewers and what tables need, one after another.
restoreChoices();
for (const figure of all('figure[data-uses]')) drawMultiples(figure);
if (!toolbar.hidden) choose();

const viewers = new Map();
function viewerOf(index) {
  if (!viewers.has(index))
    viewers.set(index, new Viewer(document.querySelector('.viewer[data-scene="' + index + '"]'), imageData.scenes[index], index));
  return viewers.get(index);
}
// A thumbnail at the top leads to its image.
document.addEventListener('click', event => {
  const link = event.target.closest('a[data-image]');
  if (!link) return;
  event.preventDefault();
  const viewer = viewerOf(Number(link.dataset.scene));
  viewer.set({left: Number(link.dataset.image)});
  viewer.root.scrollIntoView({behavior: 'smooth'});
});
document.body.dataset.ready = Math.round(performance.now());  // milliseconds: what a test measures

const later = all('.viewer').map(root => () => viewerOf(Number(root.dataset.scene)));
later.push(...tableFigures.map(figure => () => freeze(figure)));
const goOn = () => {
  later.shift()?.();
  if (later.length) setTimeout(goOn);
};
setTimeout(goOn);
