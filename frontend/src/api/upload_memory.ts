/** Remembers across reloads which upload belongs to which files: a fingerprint, IDs and a length, but no name. */

export interface RememberedUpload {
  readonly data_set_id: string;
  readonly upload_url: string;
  readonly bytes: number;
}

const key = "diaphane.uploads";
const most = 20;

type Store = Pick<Storage, "getItem" | "setItem">;

function all(store: Store): Record<string, RememberedUpload> {
  try {
    const value: unknown = JSON.parse(store.getItem(key) ?? "{}");
    return typeof value === "object" && value !== null ? (value as Record<string, RememberedUpload>) : {};
  } catch {
    return {};
  }
}

export function rememberedUpload(store: Store, fingerprint: string): RememberedUpload | null {
  return all(store)[fingerprint] ?? null;
}

export function rememberUpload(store: Store, fingerprint: string, upload: RememberedUpload): void {
  const kept = Object.entries(all(store))
    .filter(([print]) => print !== fingerprint)
    .slice(1 - most);
  store.setItem(key, JSON.stringify(Object.fromEntries([...kept, [fingerprint, upload]])));
}

export function forgetUpload(store: Store, dataSetId: string): void {
  const kept = Object.entries(all(store)).filter(([, upload]) => upload.data_set_id !== dataSetId);
  store.setItem(key, JSON.stringify(Object.fromEntries(kept)));
}
