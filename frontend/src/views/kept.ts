type Store = Pick<Storage, "getItem" | "setItem">;
// Where storage is blocked, even looking at it throws: only when it is used.
const local = (): Store => localStorage;

/** What this browser was told to keep; nothing where it has nothing, or nothing may be kept. */
export function kept(key: string, store: () => Store = local): string | null {
  try {
    return store().getItem(key);
  } catch {
    return null;
  }
}

/** Whether it is kept now. */
export function keep(key: string, value: string, store: () => Store = local): boolean {
  try {
    store().setItem(key, value);
    return store().getItem(key) === value;
  } catch {
    return false; // blocked, or full
  }
}
