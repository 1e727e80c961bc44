// Elements of a page, and files that it saves.
export function element(tag, more = {}, ...children) {
  const e = document.createElement(tag);
  for (const [key, value] of Object.entries(more)) key in e ? (e[key] = value) : e.setAttribute(key, value);
  e.append(...children);
  return e;
}
export const button = (text, act, more = {}) => element('button', { type: 'button', textContent: text, onclick: act, ...more });

export function download(name, blob) {
  const link = element('a', { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
