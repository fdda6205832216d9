import { randomUUID } from "node:crypto";
import type { IncomingMessage, ServerResponse } from "node:http";
import type { Duplex } from "node:stream";
import type { Plugin, PreviewServer } from "vite";
import { WebSocketServer } from "ws";
import type { Alignment } from "../../src/api/alignments";
import type { DataSet, Me } from "../../src/api/types";
import { fromJson, type JsonValue } from "@bufbuild/protobuf";
import { SceneSchema } from "../../src/protocol/gen/api/proto/scene_pb";
import { draw } from "./picture";
import { sceneNamed, serveStream, type FakeSession } from "./stream";
import { answerParticipant, answerResearcher } from "./studies";

/** What Vite's development and preview servers have in common. */
interface Emitter {
  /** Milliseconds. HTTP/2 has none. */
  keepAliveTimeout?: number;
  on(event: "upgrade", listener: (request: IncomingMessage, socket: Duplex, head: Buffer) => void): unknown;
}

const me: Me = {
  id: randomUUID(),
  email: "anna@example.org",
  csrf_token: "0".repeat(64),
  administrator: false,
  researcher: true,
  archive_access: false,
  second_factor: false,
  consent: { version: "2026-11-27", given_at: "2026-11-26T00:00:00.000Z" },
  quota: { bytes: 20e9, used_bytes: 3.1e9 },
  render_time: { quota_ms: 72_000_000, used_ms: 0, renewed_at: "2027-01-01T00:00:00.000Z", pictures_end_at: null },
};
let signedIn = false;
const now = () => new Date().toISOString();
const base = {
  description: "",
  body_part: null,
  role: "owner" as const,
  owner_name: "",
  shared: null,
  taken_down: null,
  published_at: null,
  anonymised_at: null,
  owned: true,
  is_public: false,
  is_sample: false,
  public_downloads: true,
  public_slices: false,
  refusal: null,
  volume: null,
  upload: null,
  labels: null,
  waiting_for: null,
  created_at: now(),
  updated_at: now(),
};
const volume = {
  modality: "CT" as const,
  size: [256, 256, 108] as const,
  phases: 1,
  spacing_mm: [0.957, 0.957, 1.5] as const,
  bytes: 14e6,
  repairs: [],
};
const sets: DataSet[] = [
  { ...base, id: randomUUID(), title: "Head, spring", state: "ready", volume },
  {
    ...base,
    id: randomUUID(),
    title: "Knee after the fall",
    state: "ready",
    volume: { ...volume, modality: "MR", repairs: ["1 slice was on the disc twice"] },
  },
  { ...base, id: randomUUID(), title: "", state: "building" },
  {
    ...base,
    id: randomUUID(),
    title: "Chest",
    state: "refused",
    refusal: { code: "missing_slices", text: "3 slices are missing; copy the disc again." },
  },
  {
    ...base,
    id: randomUUID(),
    title: "Shoulder",
    state: "uploading",
    upload: { url: "/v1/uploads/x", bytes: 2e8, received_bytes: 7.4e7, expires_at: now() },
  },
  { ...base, id: randomUUID(), title: "Beating heart", state: "ready", volume },
  { ...base, id: randomUUID(), title: "", owned: false, is_public: true, is_sample: true, state: "ready", volume },
];
const received = new Map<string, number>();
/** The alignments by the IDs of both scans. CT scans share a frame of reference. */
const alignments = new Map<string, Alignment>();
const motion = [1, 0, 0, 4, 0, 1, 0, -6, 0, 0, 1, 10, 0, 0, 0, 1];

function alignmentOf(first: DataSet, second: string): Alignment {
  const other = sets.find((one) => one.id === second);
  const shared = first.volume?.modality === "CT" && other?.volume?.modality === "CT";
  const none: Alignment = {
    state: shared ? "ready" : "none",
    frame_of_reference_shared: shared,
    matrix: shared ? motion : null,
    scene_matrix: shared ? motion : null,
    residual_mm: null,
    overlap: null,
    reason: null,
    may_align: true,
  };
  return alignments.get(`${first.id} ${second}`) ?? none;
}

function align(first: DataSet, second: string): Alignment {
  const key = `${first.id} ${second}`;
  const now = alignmentOf(first, second);
  if (now.state !== "none") return now;
  const running: Alignment = { ...now, state: "running" };
  alignments.set(key, running);
  const found = { matrix: motion, scene_matrix: motion, residual_mm: 1.3, overlap: 0.87 };
  setTimeout(() => alignments.set(key, { ...running, state: "ready", ...found }), 2500);
  return running;
}

const sessions = new Map<string, FakeSession>();

async function bodyOf(request: IncomingMessage): Promise<Buffer> {
  const parts: Buffer[] = [];
  for await (const part of request) parts.push(part as Buffer);
  return Buffer.concat(parts);
}

async function answer(request: IncomingMessage, response: ServerResponse): Promise<void> {
  const path = (request.url ?? "").split("?")[0] ?? "";
  const [, , kind = "", id = "", more = "", name = ""] = path.split("/");
  const body = await bodyOf(request);
  const say = (status: number, value?: unknown, headers: Record<string, string> = {}) => {
    response.writeHead(status, { "Content-Type": "application/json", ...headers });
    response.end(value === undefined ? undefined : JSON.stringify(value));
  };
  const problem = (status: number, type: string) =>
    say(status, { type: `urn:diaphane:problem:${type}`, title: type, status, request_id: "x" });
  const set = sets.find((one) => one.id === id);
  if (kind === "studies") {
    answerResearcher(request.method ?? "", [id, more, name], body, say, response);
    return;
  }
  if (kind === "study") {
    answerParticipant(id, body, say, response, (scene) => {
      const session = randomUUID();
      sessions.set(session, { scene: fromJson(SceneSchema, scene as JsonValue), inputSeq: 0n, epoch: 1n });
      return { session_id: session, stream_url: `/stream?ticket=${session}`, expires_at: now() };
    });
    return;
  }
  if (more === "tour" || id === "tour") {
    say(200, { tour: null });
    return;
  }
  if (kind === "perception") {
    say(200, { comfort: null });
    return;
  }
  switch (`${request.method ?? ""} ${kind}`) {
    case "POST accounts":
      say(more === "" && id === "" ? 202 : 204);
      return;
    case "POST sign-in":
      if (body.includes("wrong")) {
        problem(401, "wrong-credentials");
        return;
      }
      signedIn = true;
      say(200, me);
      return;
    case "POST sign-out":
      signedIn = false;
      say(204);
      return;
    case "GET me":
      if (signedIn) say(200, me);
      else problem(401, "unauthenticated");
      return;
    case "GET data-sets": {
      if (id === "") {
        say(200, { items: sets, next_cursor: null });
        return;
      }
      if (!set) {
        problem(404, "not-found");
        return;
      }
      if (more === "export") {
        problem(404, "not-found"); // nothing was exported
        return;
      }
      if (more === "presets") {
        say(200, { items: [], next_cursor: null });
        return;
      }
      if (more === "alignments") {
        say(200, alignmentOf(set, name));
        return;
      }
      if (more !== "thumbnails") {
        say(200, set);
        return;
      }
      response.writeHead(200, { "Content-Type": "image/jpeg" });
      response.end(draw(sceneNamed(name), 640, 640, 400));
      return;
    }
    case "POST data-sets": {
      const wanted = JSON.parse(body.toString()) as { title: string; bytes: number };
      const made = randomUUID();
      const upload = { url: `/v1/uploads/${made}`, bytes: wanted.bytes, received_bytes: 0, expires_at: now() };
      sets.unshift({ ...base, id: made, title: wanted.title, state: "uploading", upload });
      received.set(made, 0);
      say(201, { data_set: sets[0], upload_url: upload.url });
      return;
    }
    case "PUT data-sets":
      if (set) say(201, align(set, name));
      else problem(404, "not-found");
      return;
    case "DELETE data-sets":
      if (set && more === "alignments") alignments.delete(`${set.id} ${name}`);
      else if (set) sets.splice(sets.indexOf(set), 1);
      say(204);
      return;
    case "HEAD uploads":
      say(200, undefined, {
        "Upload-Offset": String(received.get(id) ?? 0),
        "Upload-Length": String(set?.upload?.bytes ?? 0),
        "Tus-Resumable": "1.0.0",
      });
      return;
    case "PATCH uploads": {
      const offset = (received.get(id) ?? 0) + body.length;
      received.set(id, offset);
      if (set && offset >= (set.upload?.bytes ?? 0)) {
        const at = sets.indexOf(set);
        sets[at] = { ...set, state: "building", upload: null };
        setTimeout(() => (sets[at] = { ...set, state: "ready", upload: null, volume }), 3000);
      }
      say(204, undefined, { "Upload-Offset": String(offset), "Tus-Resumable": "1.0.0" });
      return;
    }
    case "POST sessions": {
      const session = more === "tickets" ? id : randomUUID();
      if (more === "tickets" && !sessions.has(id)) {
        problem(404, "not-found");
        return;
      }
      if (!sessions.has(session)) {
        const wanted = JSON.parse(body.toString()) as { data_set_id: string; over?: string };
        const phases = sets.find(({ id }) => id === wanted.data_set_id)?.title === "Beating heart" ? 20 : 0;
        const fused = wanted.over !== undefined;
        sessions.set(session, { scene: sceneNamed("skin"), inputSeq: 0n, epoch: 1n, phases, fused });
      }
      say(201, { session_id: session, stream_url: `/stream?ticket=${session}` });
      return;
    }
    default:
      say(204);
      return;
  }
}

export function fakeServer(): Plugin {
  const serve = ({ middlewares, httpServer }: Pick<PreviewServer, "middlewares"> & { httpServer: Emitter | null }) => {
    middlewares.use((request, response, next) => {
      if (request.url?.startsWith("/v1/")) void answer(request, response);
      else next();
    });
    // A client that reuses a connection just when the server ends it gets a reset instead of an answer.
    if (httpServer) httpServer.keepAliveTimeout = 0;
    const streams = new WebSocketServer({ noServer: true });
    httpServer?.on("upgrade", (request: IncomingMessage, socket: Duplex, head: Buffer) => {
      if (!request.url?.startsWith("/stream")) return;
      const session = sessions.get(new URL(request.url, "http://x").searchParams.get("ticket") ?? "");
      streams.handleUpgrade(request, socket, head, (ws) => {
        if (session) serveStream(ws, session);
        else ws.close(4401);
      });
    });
  };
  return { name: "fake-server", configureServer: serve, configurePreviewServer: serve };
}
