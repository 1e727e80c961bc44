// Dropped files: passed to the part of the page that handles their name; any other file is an environment map.
export function take_dropped_files(view) {
  for (const name of ['dragover', 'dragleave', 'drop']) addEventListener(name, (e) => dragged(e, view));
}

function dragged(e, view) {
  e.preventDefault();
  document.body.classList.toggle('dropping', e.type === 'dragover');
  const file = e.type === 'drop' && e.dataTransfer?.files[0];
  if (!file) return;
  const part = view.filed.find((p) => p.opens.test(file.name));
  if (part) part.open(file);
  else if (view.scene.relit) view.light_of(file);
  else view.tell('This scene has no materials, so another light cannot fall on it: finish `vitrine run`, then `vitrine view`.');
}
