import type { Api } from "../api/client";
import { random_key } from "../api/random_key";
import { guest_door, session_door, visit_door } from "../api/session_door";
import type { Door } from "../protocol/stream_client";

/** Where a viewer's pictures come from, and under which name the page remembers the view of it. */
export interface Place {
  readonly key: string;
  /** Of one's own scans; of a guest there is none. */
  readonly data_set_id: string | null;
  door(known: string | null, session: (id: string) => void): Door;
  /** The page is left for another. */
  leave(session_id: string | null): void;
}

export function own_place(api: Api, data_set_id: string): Place {
  return {
    key: data_set_id,
    data_set_id,
    door: (known, session) => session_door(api, data_set_id, known, session),
    leave: (session_id) => {
      if (session_id !== null) void api.end_session(session_id).catch(() => undefined);
    },
  };
}

export function guest_place(api: Api, token: string, guest: Guest): Place {
  return {
    key: `guest.${token.slice(0, 8)}`,
    data_set_id: null,
    door: () => guest_door(api, token, guest.key, guest.name),
    leave: () => undefined,
  };
}

/** Looking without an account: at a sample, or by a link. */
export function visit_place(api: Api, what: { readonly token: string } | { readonly data_set_id: string }, key: string): Place {
  return {
    key: `visit.${key.slice(0, 8)}`,
    data_set_id: null,
    door: () => visit_door(api.sharing, what, key),
    leave: () => undefined,
  };
}

/** Who one is at a link: kept for this tab alone, so that a reload is the same guest again. */
export interface Guest {
  readonly key: string;
  readonly name: string;
}

type Store = Pick<Storage, "getItem" | "setItem">;
const key_of = (token: string) => `diaphane.guest.${token.slice(0, 8)}`;

export function remembered_guest(store: Store, token: string): Guest | null {
  try {
    const value = JSON.parse(store.getItem(key_of(token)) ?? "null") as Record<string, unknown> | null;
    const { key, name } = value ?? {};
    return typeof key === "string" && key.length === 64 && typeof name === "string" ? { key, name } : null;
  } catch {
    return null;
  }
}

export function new_guest(store: Store, token: string, name: string): Guest {
  const guest = { key: random_key() + random_key(), name: name.trim().slice(0, 40) };
  store.setItem(key_of(token), JSON.stringify(guest));
  return guest;
}
