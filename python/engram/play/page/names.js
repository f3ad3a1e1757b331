// Names of tasks for people: families in words, variants by what sets them apart.
const WORD = /([a-z0-9])([A-Z])/g;

// "RememberShapeAndColor" is "Remember Shape And Color".
export const familyName = (family) => family.replace(WORD, '$1 $2');

// What is left of an id without its family: "3, Long"; null if that is nothing.
export function variantName(task) {
  const core = task.id.replace(/(-VLA)?-v[0-9]+$/, '');
  if (!core.startsWith(task.family)) return core;
  const rest = core.slice(task.family.length).split('-').filter(Boolean);
  return rest.length ? rest.join(', ').replace(WORD, '$1 $2') : null;
}

// Spellings of other countries; the ids and instructions have the American ones.
const SPELLINGS = [[/colour/g, 'color'], [/grey/g, 'gray'], [/centre/g, 'center'], [/impostor/g, 'imposter']];

export function searchable(text) {
  let plain = text.toLowerCase();
  for (const [from, to] of SPELLINGS) plain = plain.replace(from, to);
  return plain;
}

// An id that breaks between its words only.
export function breakable(id) {
  const parts = id.split(/(?<=-)|(?<=[a-z0-9])(?=[A-Z])/);
  return parts.flatMap((part, i) => (i ? [document.createElement('wbr'), part] : [part]));
}

// Instructions have places for numbers that each episode draws.
export const withoutPlaces = (instruction) => instruction.replace(/\{\w+\}/g, '…');
