'use strict';
// Photo against render: the range input over a picture moves the border between the two.
for (const pair of document.querySelectorAll('.pair')) {
  const range = pair.querySelector('input[type=range]');
  const move = () => pair.style.setProperty('--split', range.value + '%');
  range.addEventListener('input', move);
  pair.classList.add('live');
  move();
}
