import type { Trouble } from "../protocol/connection";
import type { Door } from "../protocol/stream_client";
import { ApiProblem } from "./client";
import type { Stream } from "./types";

/** What of the API a door needs. */
export interface SessionApi {
  create_session(data_set_id: string, signal?: AbortSignal): Promise<Stream>;
  create_ticket(session_id: string, signal?: AbortSignal): Promise<Stream>;
}

/**
 * Leads to the session that this page had; where that is gone, to a new one of the same data set.
 * `session` is told each time which it is.
 */
export function session_door(api: SessionApi, data_set_id: string, known: string | null, session: (id: string) => void): Door {
  let id = known;
  return async (signal) => {
    try {
      const stream = (id === null ? null : await again(api, id, signal)) ?? (await api.create_session(data_set_id, signal));
      id = stream.session_id;
      session(id);
      return { ok: true, url: stream.stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      return { ok: false, ...refusal(thrown), retry_after_ms: thrown.retry_after_ms };
    }
  };
}

/** What of the API a guest's door needs. */
export interface JoinApi {
  join(token: string, key: string, name: string, signal?: AbortSignal): Promise<{ readonly stream_url: string }>;
}

/** Leads to somebody's session by a link; the same key is the same guest again. */
export function guest_door(api: JoinApi, token: string, key: string, name: string): Door {
  return async (signal) => {
    try {
      return { ok: true, url: (await api.join(token, key, name, signal)).stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      if (thrown.status === 404) return { ok: false, trouble: "link_ended", final: true };
      return { ok: false, ...refusal(thrown), retry_after_ms: thrown.retry_after_ms };
    }
  };
}

/** What of the API a visitor's door needs. */
export interface VisitApi {
  visit(what: { readonly token: string } | { readonly data_set_id: string }, key: string, signal?: AbortSignal): Promise<{ readonly stream_url: string }>;
}

/** Leads to a visitor's session; the same key is the same visit again, until it is over. */
export function visit_door(api: VisitApi, what: { readonly token: string } | { readonly data_set_id: string }, key: string): Door {
  return async (signal) => {
    try {
      return { ok: true, url: (await api.visit(what, key, signal)).stream_url };
    } catch (thrown) {
      if (!(thrown instanceof ApiProblem)) throw thrown;
      if (thrown.status === 404) return { ok: false, trouble: "link_ended", final: true };
      return { ok: false, ...refusal(thrown), retry_after_ms: thrown.retry_after_ms };
    }
  };
}

async function again(api: SessionApi, id: string, signal: AbortSignal): Promise<Stream | null> {
  try {
    return await api.create_ticket(id, signal);
  } catch (thrown) {
    if (thrown instanceof ApiProblem && thrown.status === 404) return null;
    throw thrown;
  }
}

function refusal(problem: ApiProblem): { trouble: Trouble; final: boolean } {
  if (problem.status === 401) return { trouble: "signed_out", final: true };
  if (problem.status === 404) return { trouble: "not_found", final: true };
  if (problem.kind === "render-time-spent") return { trouble: "time_spent", final: true };
  if (problem.kind === "not-ready") return { trouble: "not_ready", final: false };
  if (problem.kind === "no-worker") return { trouble: "no_worker", final: false };
  return { trouble: "unreachable", final: false };
}
