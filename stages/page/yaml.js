// The part of YAML that files of people use (maps, lists, their short forms in brackets, quotes, comments), read; and texts in quotes.
// Scalars are strings. Other YAML is refused at its line.
class YamlError extends Error {
  constructor(line, text) {
    super(`line ${line}: ${text}`);
  }
}

// Without a comment; quotes protect '#'.
function content_of(raw) {
  let quote = '';
  for (let i = 0; i < raw.length; ++i) {
    const c = raw[i], begins = i === 0 || /[\s[{,:]/.test(raw[i - 1]);
    if (quote) {
      if (c === '\\' && quote === '"') ++i;
      else if (c === quote) quote = '';
    } else if ((c === '"' || c === "'") && begins) quote = c;
    else if (c === '#' && (i === 0 || /\s/.test(raw[i - 1]))) return raw.slice(0, i).trimEnd();
  }
  return raw.trimEnd();
}

// How many brackets stay open.
function open_brackets(text) {
  return [...text.replace(/"(?:[^"\\]|\\.)*"|'[^']*'/g, '')].reduce((n, c) => n + ('[{'.includes(c) ? 1 : 0) - (']}'.includes(c) ? 1 : 0), 0);
}

const kKey = /^("(?:[^"\\]|\\.)*"|'(?:[^']|'')*'|[^\s"'[\]{},][^[\]{},]*?)\s*:(?:\s+|$)/;

function scalar(text, line) {
  if (/^[&*!|>%@`]/.test(text)) throw new YamlError(line, `\u201c${text.slice(0, 20)}\u201d is a kind of YAML that is not read here`);
  if (text.startsWith('"')) {
    try {
      return JSON.parse(text);
    } catch {
      throw new YamlError(line, 'this text in quotes does not end, or has an escape that is not known here');
    }
  }
  if (text.startsWith("'")) {
    if (!/^'(?:[^']|'')*'$/.test(text)) throw new YamlError(line, 'this text in quotes does not end');
    return text.slice(1, -1).replaceAll("''", "'");
  }
  return text === '~' || text === 'null' ? null : text;
}

// [a, b] and {a: b}, from text that closes all its brackets.
function flow(text, line) {
  let at = 0;
  const skip = () => (at += text.slice(at).match(/^\s*/)[0].length);
  const fail = (what) => {
    throw new YamlError(line, what);
  };
  const value = () => {
    skip();
    if (text[at] === '[') {
      const list = [];
      for (++at, skip(); text[at] !== ']'; skip()) {
        list.push(value()), skip();
        if (text[at] === ',') ++at;
        else if (text[at] !== ']') fail('expected , or ]');
      }
      return ++at, list;
    }
    if (text[at] === '{') {
      const map = Object.create(null);
      for (++at, skip(); text[at] !== '}'; skip()) {
        const key = word(/^("(?:[^"\\]|\\.)*"|'(?:[^']|'')*'|[^,:[\]{}]+)/);
        skip();
        if (text[at] !== ':') fail(`expected : after ${key}`);
        ++at;
        if (key in map) fail(`'${key}' is given twice`);
        map[key] = value(), skip();
        if (text[at] === ',') ++at;
        else if (text[at] !== '}') fail('expected , or }');
      }
      return ++at, map;
    }
    return word(/^("(?:[^"\\]|\\.)*"|'(?:[^']|'')*'|[^,[\]{}]*)/);
  };
  const word = (pattern) => {
    const found = text.slice(at).match(pattern)?.[0] ?? '';
    if (!found && at >= text.length) fail('a bracket is not closed');
    at += found.length;
    return scalar(found.trim(), line);
  };
  const out = value();
  skip();
  if (at < text.length) fail(`unexpected \u201c${text.slice(at, at + 20)}\u201d`);
  return out;
}

export function read_yaml(text) {
  const lines = [];
  text.replace(/^\ufeff/, '').split(/\r?\n/).forEach((raw, i) => {
    const content = content_of(raw);
    if (!content.trim() || (content === '---' && !lines.length)) return;
    const indent = content.match(/^ */)[0].length;
    if (content[indent] === '\t') throw new YamlError(i + 1, 'a tab stands where YAML wants spaces');
    lines.push({ line: i + 1, indent, text: content.slice(indent) });
  });
  let at = 0;
  // A value that begins on this line with `text`, whose lists and maps below have more than `indent`, or lists as many.
  const value = (text, line, indent) => {
    if (text) {
      while ('[{'.includes(text[0]) && open_brackets(text) > 0 && at < lines.length) text += ` ${lines[at++].text}`;
      return '[{'.includes(text[0]) ? flow(text, line) : scalar(text, line);
    }
    const next = lines[at];
    if (!next || next.indent < indent || (next.indent === indent && !/^-(\s|$)/.test(next.text))) return null;
    return block(next.indent);
  };
  const block = (indent) => {
    const first = lines[at];
    if (/^-(\s|$)/.test(first.text)) {
      const list = [];
      while (at < lines.length && lines[at].indent === indent && /^-(\s|$)/.test(lines[at].text)) {
        const { line, text } = lines[at], rest = text.slice(1).trimStart();
        if (rest && (kKey.test(rest) || /^-(\s|$)/.test(rest)) && !'[{'.includes(rest[0])) {
          lines[at] = { line, indent: indent + text.length - rest.length, text: rest };
          list.push(block(lines[at].indent));
        } else {
          ++at;
          list.push(value(rest, line, indent + 1));
        }
      }
      return list;
    }
    if (!kKey.test(first.text) || '[{'.includes(first.text[0])) {
      ++at;
      return value(first.text, first.line, indent);
    }
    const map = Object.create(null);
    while (at < lines.length && lines[at].indent === indent) {
      const { line, text } = lines[at++], found = text.match(kKey);
      if (!found) throw new YamlError(line, `expected a name and a colon, found \u201c${text.slice(0, 20)}\u201d`);
      const key = scalar(found[1], line);
      if (key in map) throw new YamlError(line, `'${key}' is given twice`);
      map[key] = value(text.slice(found[0].length), line, indent);
    }
    return map;
  };
  if (!lines.length) return null;
  const root = block(lines[0].indent);
  if (at < lines.length) throw new YamlError(lines[at].line, 'this does not stand under anything: check the spaces before it');
  return root;
}

const plain = (text) => /^[A-Za-z_][\w./-]*$/.test(text) && !/^(true|false|yes|no|on|off|null|y|n)$/i.test(text);
// A text as a scalar.
export const quoted = (text) => (plain(text) ? text : JSON.stringify(text));
