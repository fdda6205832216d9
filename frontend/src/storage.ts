/** The part of the browser's storage that the page uses. */
export type Browsers = Pick<Storage, "getItem" | "setItem" | "removeItem" | "clear">;

export interface Keeping extends Browsers {
  /** Returns whether the value outlasts the page. */
  keep(key: string, value: string): boolean;
}

/**
 * Returns the browser's storage where it is available. Access throws where it is blocked, a full
 * one rejects values, and some browsers drop them immediately. In these cases, values last until
 * the page closes.
 */
export function keeping(browsers: () => Browsers): Keeping {
  const memory = new Map<string, string>();
  const possibly = <Value>(operation: () => Value): { readonly value: Value } | null => {
    try {
      return { value: operation() };
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

/** Storage of this browser, shared by all tabs. */
export const local = keeping(() => localStorage);
/** Storage of this tab, which survives a reload. */
export const tab = keeping(() => sessionStorage);
