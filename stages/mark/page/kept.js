// Unsaved marks in localStorage between visits, keyed by the contents of the photos.
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
  // Returns false if the browser could not store the state.
  write(state) {
    try {
      localStorage.setItem(this.key, JSON.stringify({ ...state, time: Date.now() }));
      return true;
    } catch {
      return false;
    }
  }
}
