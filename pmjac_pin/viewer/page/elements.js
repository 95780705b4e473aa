// The page's elements: found, made, and told what they read.

export const $ = (id) => document.getElementById(id);

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Long names may be broken after an underscore.
export const broken = (name) => name.split("_").flatMap((part, k) => (k ? ["_", element("wbr"), part] : [part]));
