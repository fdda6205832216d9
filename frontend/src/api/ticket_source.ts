import type { Trouble } from "../protocol/connection";
import type { TicketSource } from "../protocol/stream_client";
import { ApiProblem } from "./client";
import type { Stream } from "./types";

/** The part of the API that tickets for the user's own sessions need. */
export interface SessionApi {
  createSession(dataSetId: string, signal?: AbortSignal, over?: string): Promise<Stream>;
  createTicket(sessionId: string, signal?: AbortSignal): Promise<Stream>;
}

/**
 * Tickets for this page's session or, if it no longer exists, for a new one of the same data set. `over` is the scan that
 * it shows over the data set, if any. Each ticket calls `session` with the session's ID.
 */
export function sessionTicketSource(
  api: SessionApi,
  dataSetId: string,
  known: string | null,
  session: (id: string) => void,
  over?: string,
): TicketSource {
  let id = known;
  return async (signal) => {
    try {
      const stream =
        (id === null ? null : await again(api, id, signal)) ?? (await api.createSession(dataSetId, signal, over));
      id = stream.session_id;
      session(id);
      return { ok: true, url: stream.stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      return { ok: false, ...refusal(thrown), retryAfterMs: thrown.retryAfterMs };
    }
  };
}

/** The part of the API that a guest's tickets need. */
export interface JoinApi {
  join(token: string, key: string, name: string, signal?: AbortSignal): Promise<{ readonly stream_url: string }>;
}

/** Tickets for another person's session by a link. The same key identifies the same guest again. */
export function guestTicketSource(api: JoinApi, token: string, key: string, name: string): TicketSource {
  return async (signal) => {
    try {
      return { ok: true, url: (await api.join(token, key, name, signal)).stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      return { ok: false, ...refusalOfGuest(thrown), retryAfterMs: thrown.retryAfterMs };
    }
  };
}

/** The part of the API that a visitor's tickets need. */
export interface VisitApi {
  visit(
    what: { readonly token: string } | { readonly data_set_id: string },
    key: string,
    signal?: AbortSignal,
  ): Promise<{ readonly stream_url: string }>;
}

/** Tickets for a visitor's session. The same key continues the same visit until it is over. */
export function visitTicketSource(
  api: VisitApi,
  what: { readonly token: string } | { readonly data_set_id: string },
  key: string,
): TicketSource {
  return async (signal) => {
    try {
      return { ok: true, url: (await api.visit(what, key, signal)).stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      return { ok: false, ...refusalOfGuest(thrown), retryAfterMs: thrown.retryAfterMs };
    }
  };
}

/** The part of the API that the pictures of a study's step need. */
export interface StudyVisitApi {
  visit(key: string, step: string, signal: AbortSignal): Promise<{ readonly stream_url: string }>;
}

/** Tickets for the pictures of one step of a study. They end with the study, of which `over` is told. */
export function studyTicketSource(
  api: StudyVisitApi,
  key: string,
  step: string,
  over: (problem: ApiProblem) => void,
): TicketSource {
  return async (signal) => {
    try {
      return { ok: true, url: (await api.visit(key, step, signal)).stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      const gone = thrown.status === 410;
      if (gone) over(thrown);
      const why = gone ? { trouble: "link_ended" as const, final: true } : refusalOfGuest(thrown);
      return { ok: false, ...why, retryAfterMs: thrown.retryAfterMs };
    }
  };
}

async function again(api: SessionApi, id: string, signal: AbortSignal): Promise<Stream | null> {
  try {
    return await api.createTicket(id, signal);
  } catch (thrown) {
    if (thrown instanceof ApiProblem && thrown.status === 404) return null;
    throw thrown;
  }
}

function refusalOfGuest(problem: ApiProblem): { trouble: Trouble; final: boolean } {
  if (problem.status === 404) return { trouble: "link_ended", final: true };
  if (problem.kind === "busy") return { trouble: "guests_full", final: false };
  return refusal(problem);
}

function refusal(problem: ApiProblem): { trouble: Trouble; final: boolean } {
  if (problem.status === 401) return { trouble: "signed_out", final: true };
  if (problem.status === 404) return { trouble: "not_found", final: true };
  if (problem.kind === "render-time-spent") return { trouble: "time_spent", final: true };
  if (problem.kind === "not-ready") return { trouble: "not_ready", final: false };
  if (problem.kind === "no-worker") return { trouble: "no_worker", final: false };
  return { trouble: "unreachable", final: false };
}
