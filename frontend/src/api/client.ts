import { AlignmentsApi } from "./alignments";
import { ApiTokensApi } from "./api_tokens";
import { AnnotationsApi } from "./annotations";
import { AnonymiseApi } from "./anonymise";
import { ArchivesApi } from "./archives";
import { EnvironmentsApi } from "./environments";
import { ScanExportsApi } from "./scan_exports";
import { SecondFactorApi } from "./second_factor";
import { PresetsApi, SharingApi } from "./sharing";
import { StudiesApi } from "./studies";
import { language } from "../texts";
import type {
  AuditEntry,
  BrowserSession,
  DataSet,
  Export,
  Fleet,
  Listed,
  Me,
  PresetName,
  ProblemBody,
  Recordings,
  Stream,
  User,
} from "./types";

/** An error response of the server (RFC 9457). If there was no response at all, `status` is 0. */
export class ApiProblem extends Error {
  constructor(
    readonly status: number,
    /** The last part of the problem's `type`, such as "over-quota", or "offline" if there was no response. */
    readonly kind: string,
    /** A sentence for the user, or empty. */
    readonly detail: string,
    readonly errors: readonly { readonly field: string; readonly message: string }[] = [],
    readonly retryAfterMs = 0,
  ) {
    super(`${kind} (${status})`);
  }
}

const prefix = "urn:diaphane:problem:";

export async function problemOf(response: Response): Promise<ApiProblem> {
  let body: Partial<ProblemBody> = {};
  try {
    body = (await response.json()) as Partial<ProblemBody>;
  } catch {
    // The response is not from our server but from a proxy in between.
  }
  const type =
    typeof body.type === "string" && body.type.startsWith(prefix) ? body.type.slice(prefix.length) : "internal";
  const seconds = Number(response.headers.get("Retry-After") ?? "0");
  return new ApiProblem(
    response.status,
    type,
    body.detail ?? "",
    body.errors ?? [],
    Number.isFinite(seconds) ? seconds * 1000 : 0,
  );
}

/** The REST API, one function per route. Every function rejects with ApiProblem. */
export class Api {
  private token = "";

  /** Returns the CSRF token of the session, for uploads, which do not use `fetch`. */
  get csrfToken(): string {
    return this.token;
  }

  /** Requests an account for a user who has agreed to the processing of health data. */
  async signUp(email: string): Promise<void> {
    await this.send("POST", "/v1/accounts", { email, consent: true });
  }

  async giveConsent(version: string): Promise<void> {
    await this.send("POST", "/v1/me/consent", { version });
  }

  /** Confirms the address of a new account, sets its password and signs in. */
  async verify(token: string, password: string): Promise<Me> {
    return this.known(await this.json<Me>("POST", "/v1/accounts/verify", { token, password }));
  }

  /** Rejects with `code-needed` if the account has a second factor and `code` is empty. */
  async signIn(email: string, password: string, code = ""): Promise<Me> {
    return this.known(await this.json<Me>("POST", "/v1/sign-in", { email, password, ...(code ? { code } : {}) }));
  }

  async signOut(): Promise<void> {
    await this.send("POST", "/v1/sign-out");
    this.token = "";
  }

  /** Returns null if nobody is signed in. */
  async me(): Promise<Me | null> {
    try {
      return this.known(await this.json<Me>("GET", "/v1/me"));
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.status === 401) return null;
      throw thrown;
    }
  }

  async requestPasswordReset(email: string): Promise<void> {
    await this.send("POST", "/v1/password-reset", { email });
  }

  async resetPassword(token: string, password: string): Promise<void> {
    await this.send("POST", "/v1/password-reset/confirm", { token, password });
  }

  async confirmEmail(token: string): Promise<void> {
    await this.send("POST", "/v1/email-change/confirm", { token });
  }

  async changePassword(current: string, password: string): Promise<void> {
    await this.send("POST", "/v1/me/password", { current, password });
  }

  async changeEmail(email: string, password: string): Promise<void> {
    await this.send("POST", "/v1/me/email", { email, password });
  }

  async browserSessions(): Promise<readonly BrowserSession[]> {
    return (await this.json<{ items: BrowserSession[] }>("GET", "/v1/me/browser-sessions")).items;
  }

  async endBrowserSession(id: string): Promise<void> {
    await this.send("DELETE", `/v1/me/browser-sessions/${id}`);
  }

  async signOutEverywhere(): Promise<void> {
    await this.send("DELETE", "/v1/me/browser-sessions");
    this.token = "";
  }

  /** Returns null if there is no export. */
  async exportState(): Promise<Export | null> {
    try {
      return await this.json<Export>("GET", "/v1/me/export");
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.status === 404) return null;
      throw thrown;
    }
  }

  requestExport(): Promise<Export> {
    return this.json("POST", "/v1/me/export");
  }

  async deleteExport(): Promise<void> {
    await this.send("DELETE", "/v1/me/export");
  }

  /** Deletes the account. `code` is needed only with a second factor. */
  async deleteAccount(password: string, code: string): Promise<void> {
    await this.send("POST", "/v1/me/deletion", { password, ...(code ? { code } : {}) });
    this.token = "";
  }

  users(query: string, cursor: string | null): Promise<Listed<User>> {
    return this.json("GET", `/v1/admin/users${queryOf({ query, cursor })}`);
  }

  changeUser(
    id: string,
    change: Partial<{
      quota_bytes: number;
      render_quota_ms: number;
      disabled: boolean;
      researcher: boolean;
      archive_access: boolean;
    }>,
  ): Promise<User> {
    return this.json("PATCH", `/v1/admin/users/${id}`, change);
  }

  audit(filter: Readonly<Record<string, string | null>>): Promise<Listed<AuditEntry>> {
    return this.json("GET", `/v1/admin/audit${queryOf(filter)}`);
  }

  fleet(): Promise<Fleet> {
    return this.json("GET", "/v1/admin/fleet");
  }

  /** Returns all scans without paging, because a user has few. */
  async dataSets(signal?: AbortSignal): Promise<DataSet[]> {
    const all: DataSet[] = [];
    let cursor: string | null = null;
    do {
      const query: string = cursor === null ? "" : `?cursor=${encodeURIComponent(cursor)}`;
      const page: { items: DataSet[]; next_cursor: string | null } = await this.json(
        "GET",
        `/v1/data-sets${query}`,
        undefined,
        signal ? { signal } : {},
      );
      all.push(...page.items);
      cursor = page.next_cursor;
    } while (cursor !== null);
    return all;
  }

  dataSet(id: string): Promise<DataSet> {
    return this.json("GET", `/v1/data-sets/${id}`);
  }

  createDataSet(
    title: string,
    bytes: number,
    slices: number,
    key: string,
  ): Promise<{ data_set: DataSet; upload_url: string }> {
    return this.json("POST", "/v1/data-sets", { title, bytes, slices }, { headers: { "Idempotency-Key": key } });
  }

  async deleteDataSet(id: string): Promise<void> {
    await this.send("DELETE", `/v1/data-sets/${id}`);
  }

  addLabels(id: string, bytes: number): Promise<{ data_set: DataSet; upload_url: string }> {
    return this.json("POST", `/v1/data-sets/${id}/labels`, { bytes });
  }

  async removeLabels(id: string): Promise<void> {
    await this.send("DELETE", `/v1/data-sets/${id}/labels`);
  }

  /** Opens a session on a scan. `over` is the scan that it shows over the first one, if any. */
  createSession(dataSetId: string, signal?: AbortSignal, over?: string): Promise<Stream> {
    const body = { data_set_id: dataSetId, ...(over === undefined ? {} : { over }) };
    return this.json("POST", "/v1/sessions", body, signal ? { signal } : {});
  }

  createTicket(sessionId: string, signal?: AbortSignal): Promise<Stream> {
    return this.json("POST", `/v1/sessions/${sessionId}/tickets`, undefined, signal ? { signal } : {});
  }

  async endSession(sessionId: string): Promise<void> {
    await this.send("DELETE", `/v1/sessions/${sessionId}`, undefined, { keepalive: true });
  }

  /** Creates a link to a session. With `slices`, its guests may look through all slices. */
  createLink(sessionId: string, slices: boolean): Promise<{ token: string; path: string }> {
    return this.json("POST", `/v1/sessions/${sessionId}/links`, { slices });
  }

  async endLinks(sessionId: string): Promise<void> {
    await this.send("DELETE", `/v1/sessions/${sessionId}/links`);
  }

  /** Joins another person's session as a guest. Needs no account. */
  join(
    token: string,
    key: string,
    name: string,
    signal?: AbortSignal,
  ): Promise<{ participant: string; stream_url: string }> {
    return this.json("POST", "/v1/join", { token, key, name }, signal ? { signal } : {});
  }

  recordings(): Promise<Recordings> {
    return this.json("GET", "/v1/recordings");
  }

  async recordInteraction(consent: boolean): Promise<void> {
    await this.send(consent ? "POST" : "DELETE", "/v1/recording-consent");
  }

  async keepRecording(recording: object, keepalive: boolean): Promise<void> {
    await this.send("POST", "/v1/recordings", recording, { keepalive });
  }

  async deleteRecording(id: string): Promise<void> {
    await this.send("DELETE", `/v1/recordings/${id}`);
  }

  async thumbnail(dataSetId: string, preset: PresetName, signal: AbortSignal): Promise<Blob> {
    const response = await this.send("GET", thumbnailPath(dataSetId, preset), undefined, { signal });
    return response.blob();
  }

  readonly sharing = new SharingApi((...call) => this.send(...call));
  readonly anonymise = new AnonymiseApi((...call) => this.send(...call));
  readonly tokens = new ApiTokensApi((...call) => this.send(...call));
  readonly secondFactor = new SecondFactorApi((...call) => this.send(...call));
  readonly scanExports = new ScanExportsApi((...call) => this.send(...call));
  readonly alignments = new AlignmentsApi((...call) => this.send(...call));
  readonly annotations = new AnnotationsApi((...call) => this.send(...call));
  readonly presets = new PresetsApi((...call) => this.send(...call));
  readonly environments = new EnvironmentsApi((...call) => this.send(...call));
  readonly studies = new StudiesApi((...call) => this.send(...call));
  readonly archives = new ArchivesApi((...call) => this.send(...call));

  private known(me: Me): Me {
    this.token = me.csrf_token;
    return me;
  }

  private async json<T>(method: string, path: string, body?: unknown, init: RequestInit = {}): Promise<T> {
    const response = await this.send(method, path, body, init);
    return (await response.json()) as T;
  }

  private async send(method: string, path: string, body?: unknown, init: RequestInit = {}): Promise<Response> {
    const headers = new Headers(init.headers);
    // The server writes emails in the language of this header. The page's language may differ from the browser's.
    headers.set("Accept-Language", language.value);
    const raw = body instanceof Blob;
    if (body !== undefined && !raw) headers.set("Content-Type", "application/json");
    if (method !== "GET" && this.token) headers.set("X-CSRF-Token", this.token);
    let response: Response;
    try {
      response = await fetch(path, {
        ...init,
        method,
        headers,
        credentials: "same-origin",
        ...(body === undefined ? {} : { body: raw ? body : JSON.stringify(body) }),
      });
    } catch (thrown) {
      if (init.signal?.aborted) throw thrown;
      throw new ApiProblem(0, "offline", "");
    }
    if (!response.ok) throw await problemOf(response);
    return response;
  }
}

/** Returns a query string such as "?a=1&b=2" of the values that are not null, or an empty string. */
function queryOf(given: Readonly<Record<string, string | null>>): string {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(given)) if (value) query.set(name, value);
  return query.size > 0 ? `?${query.toString()}` : "";
}

export const exportPath = "/v1/me/export/file";

export const recordingPath = (id: string): string => `/v1/recordings/${id}`;

export const thumbnailPath = (dataSetId: string, preset: PresetName): string =>
  `/v1/data-sets/${dataSetId}/thumbnails/${preset}`;
