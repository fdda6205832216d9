/** As much of the browser's storage as is used. */
export type Browsers = Pick<Storage, "getItem" | "setItem" | "removeItem" | "clear">;

export interface Keeping extends Browsers {
  /** Whether it outlasts the page. */
  keep(key: string, value: string): boolean;
}

/**
 * The browser's storage where it may be used. Where it is blocked, even looking at it throws, and where it is full it takes
 * nothing more, and some throw it away at once: then what is kept lasts as long as the page stands.
 */
export function keeping(browsers: () => Browsers): Keeping {
  const memory = new Map<string, string>();
  const possibly = <Value>(deed: () => Value): { readonly value: Value } | null => {
    try {
      return { value: deed() };
    } catch {
      return null;
    }
  };
  const keep = (key: string, value: string): boolean => {
    const lasts =
      possibly(() => {
        browsers().setItem(key, value);
        return browsers().getItem(key) === value;
      })?.value === true;
    if (lasts) memory.delete(key);
    else memory.set(key, value);
    return lasts;
  };
  return {
    keep,
    getItem: (key) => memory.get(key) ?? possibly(() => browsers().getItem(key))?.value ?? null,
    setItem: (key, value) => void keep(key, value),
    removeItem: (key) => {
      memory.delete(key);
      possibly(() => browsers().removeItem(key));
    },
    clear: () => {
      memory.clear();
      possibly(() => browsers().clear());
    },
  };
}

/** For this browser, over all its tabs. */
export const local = keeping(() => localStorage);
/** For this tab, over a reload. */
export const tab = keeping(() => sessionStorage);
