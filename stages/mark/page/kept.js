// What the browser keeps of a page between visits: the marks of these very photos, drawn and not saved yet.
export class Kept {
  constructor(id) {
    this.key = `vitrine-mark-${id}`;
  }
  read() {
    try {
      return JSON.parse(localStorage.getItem(this.key));
    } catch {
      return null;
    }
  }
  // Whether it could.
  write(state) {
    try {
      localStorage.setItem(this.key, JSON.stringify({ ...state, time: Date.now() }));
      return true;
    } catch {
      return false;
    }
  }
}
