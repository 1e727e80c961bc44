// Objects of the scene (core/scene/objects/object_set.h): visibility, and the panel section that lists them. Page address: hide=NAME
// for each hidden object.
import { button, element } from '../../page/elements.js';
import { section } from '../../page/controls.js';

export class Objects {
  // list: [{id, name, role, trust}]
  constructor(list) {
    this.list = list, this.hidden = new Set();  // ids
    this.on_change = () => {};
  }
  show(id, shown) {
    if (shown) this.hidden.delete(id);
    else this.hidden.add(id);
    this.on_change();
  }

  address() {
    return this.list.filter(({ id }) => this.hidden.has(id)).map(({ name }) => ['hide', name]);
  }
  restore(query) {
    const names = query.getAll('hide');
    this.hidden = new Set(this.list.filter(({ name }) => names.includes(name)).map(({ id }) => id));
    if (this.hidden.size) this.on_change();
  }
}

// Returns {nodes of the panel, show: called after a change}; no nodes without objects. edit(name): starts an edit of that object;
// without it the rows have no button.
export function objects_section(objects, edit) {
  if (objects.list.length === 0) return { nodes: [], show: () => {} };
  const boxes = objects.list.map(({ id }) => element('input', { type: 'checkbox', onchange: (e) => objects.show(id, e.target.checked) }));
  const rows = objects.list.map(({ name, role, trust }, i) => element('div', { className: 'row' },
    element('label', { className: 'row' }, boxes[i], element('span', { textContent: name }, element('span', { className: 'role', textContent: `${role.replace('_', ' ')}, ${trust}` }))),
    ...(edit ? [button('Edit', () => edit(name), { 'aria-label': `edit ${name}` })] : [])));
  const list = element('div', { id: 'objects', role: 'group', 'aria-label': 'visible objects' }, ...rows);
  const show = () => boxes.forEach((box, i) => (box.checked = !objects.hidden.has(objects.list[i].id)));
  show();
  return { nodes: section('Objects', list, element('p', { textContent: 'Shadows of a hidden object, and its reflections in curved mirrors, stay.' })), show };
}
