import type { AnnotationSet } from "../api/annotations";
import type { Api } from "../api/client";
import { randomKey } from "../api/random_key";
import { guestTicketSource, sessionTicketSource, visitTicketSource } from "../api/ticket_source";
import type { ScanTour } from "../api/studies";
import type { PresetName } from "../api/types";
import type { Scene } from "../protocol/messages";
import type { OpenSocket, TicketSource } from "../protocol/stream_client";

/** Pictures of one scan under its looks. */
export interface LookPictures {
  /** Identifies the scan. */
  readonly key: string;
  load(look: PresetName, signal: AbortSignal): Promise<Blob>;
}

/** The source of a viewer's pictures, and the key under which the page remembers the view. */
export interface Place {
  readonly key: string;
  /** The scan that the user's account may open, or null for guests and visitors. */
  readonly data_set_id: string | null;
  /**
   * The pictures of the looks. Null if this person gets none: a guest of a live session sees only what its presenter
   * shows, and these pictures would show the whole scan.
   */
  readonly lookPictures: LookPictures | null;
  /** Whether this is a visit, which is over when its session is. */
  readonly isVisit: boolean;
  /** Returns the scene to begin with, in place of the server's. */
  readonly firstScene?: (scene: Scene) => Scene;
  /** Opens the stream in place of the browser's WebSocket. */
  readonly openSocket?: OpenSocket;
  /**
   * Lists the saved marks. Null if this person gets none; a guest of a live session sees those that
   * its participants show.
   */
  readonly savedMarks: (() => Promise<readonly AnnotationSet[]>) | null;
  /** Loads the tour that a study found. Null if this person gets none: it may show more than a presenter does. */
  readonly loadTour: (() => Promise<ScanTour | null>) | null;
  ticketSource(known: string | null, session: (id: string) => void): TicketSource;
  /** Tickets for a second session, which renders a file while the first one is on the page. */
  fileTicketSource(session: (id: string) => void): TicketSource;
  /** Called when the user leaves the page. */
  leave(sessionId: string | null): void;
}

export function ownPlace(api: Api, dataSetId: string): Place {
  return {
    key: dataSetId,
    data_set_id: dataSetId,
    lookPictures: { key: dataSetId, load: (look, signal) => api.thumbnail(dataSetId, look, signal) },
    isVisit: false,
    savedMarks: () => api.annotations.list(dataSetId),
    loadTour: () => api.studies.tour(dataSetId),
    ticketSource: (known, session) => sessionTicketSource(api, dataSetId, known, session),
    fileTicketSource: (session) => sessionTicketSource(api, dataSetId, null, session),
    leave: (sessionId) => {
      if (sessionId !== null) void api.endSession(sessionId).catch(() => undefined);
    },
  };
}

/**
 * Returns the place of a scan on the page that compares two scans. `side` is its side of the page. Its
 * view and its session are remembered apart from those of the viewer.
 */
export function comparedPlace(api: Api, dataSetId: string, side: number): Place {
  return { ...ownPlace(api, dataSetId), key: `compare.${side}.${dataSetId}` };
}

/** Returns the place of a scan over which a second one is shown. */
export function fusedPlace(api: Api, dataSetId: string, over: string): Place {
  return {
    ...ownPlace(api, dataSetId),
    key: `over.${dataSetId}.${over}`,
    ticketSource: (known, session) => sessionTicketSource(api, dataSetId, known, session, over),
    fileTicketSource: (session) => sessionTicketSource(api, dataSetId, null, session, over),
  };
}

export function guestPlace(api: Api, token: string, guest: Guest): Place {
  const ticketSource = () => guestTicketSource(api, token, guest.key, guest.name);
  return {
    key: `guest.${token.slice(0, 8)}`,
    data_set_id: null,
    lookPictures: null,
    isVisit: false,
    savedMarks: null,
    loadTour: null,
    ticketSource,
    fileTicketSource: ticketSource, // not used, because guests can render no files
    leave: () => undefined,
  };
}

/** Returns the place of a visit without an account: a sample, or a scan shared by link. */
export function visitPlace(
  api: Api,
  what: { readonly token: string } | { readonly data_set_id: string },
  key: string,
): Place {
  // The same key would continue the visit, and so disconnect the page.
  const fileKey = randomKey() + randomKey();
  return {
    key: `visit.${key.slice(0, 8)}`,
    data_set_id: null,
    lookPictures: {
      key: "token" in what ? what.token : what.data_set_id,
      load: (look, signal) =>
        "token" in what
          ? api.sharing.lookPicture(what.token, look, signal)
          : api.thumbnail(what.data_set_id, look, signal),
    },
    isVisit: true,
    savedMarks: () => ("token" in what ? api.annotations.follow(what.token) : api.annotations.list(what.data_set_id)),
    loadTour: () => ("token" in what ? api.studies.followTour(what.token) : api.studies.tour(what.data_set_id)),
    ticketSource: () => visitTicketSource(api.sharing, what, key),
    fileTicketSource: () => visitTicketSource(api.sharing, what, fileKey),
    leave: () => undefined,
  };
}

/** A guest's identity. Only this tab keeps it, so that a reload continues as the same guest. */
export interface Guest {
  readonly key: string;
  readonly name: string;
}

type Store = Pick<Storage, "getItem" | "setItem">;
const keyOf = (token: string) => `diaphane.guest.${token.slice(0, 8)}`;

export function rememberedGuest(store: Store, token: string): Guest | null {
  try {
    const value = JSON.parse(store.getItem(keyOf(token)) ?? "null") as Record<string, unknown> | null;
    const { key, name } = value ?? {};
    return typeof key === "string" && key.length === 64 && typeof name === "string" ? { key, name } : null;
  } catch {
    return null;
  }
}

export function newGuest(store: Store, token: string, name: string): Guest {
  const guest = { key: randomKey() + randomKey(), name: name.trim().slice(0, 40) };
  store.setItem(keyOf(token), JSON.stringify(guest));
  return guest;
}
