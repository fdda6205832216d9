import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import type { WebSocket } from "ws";
import { SceneSchema, type Scene } from "../../src/protocol/gen/api/proto/scene_pb";
import { ClientMessageSchema, Codec, FrameQuality, ServerMessageSchema, type ServerMessage } from "../../src/protocol/gen/api/proto/stream_pb";
import { draw } from "./picture";

const colours: Record<string, [number, number, number]> = { skin: [0.95, 0.72, 0.6], muscle: [0.8, 0.3, 0.26], vessels: [0.85, 0.25, 0.2], bone: [0.95, 0.92, 0.84] };

export const scene_named = (name: string): Scene => {
  const [r, g, b] = colours[name] ?? [1, 1, 1];
  return create(SceneSchema, {
    transferFunction: { extinctionPerMm: 1, channels: [{ name, diffuse: { r, g, b }, opacity: [{ value: 0, opacity: 0 }, { value: 300, opacity: 1 }] }] },
    camera: { eye: { x: 0, y: -520, z: 30 }, target: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 }, verticalFovDegrees: 30 },
  });
};

export interface FakeSession { scene: Scene; input_seq: bigint }

export function serve_stream(socket: WebSocket, session: FakeSession): void {
  let size = { width: 640, height: 480 };
  let epoch = 1n;
  let seq = 0n;
  let samples = 0;
  let begun = Date.now();
  const say = (body: ServerMessage["body"]) => socket.send(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body })));
  const restart = () => {
    epoch += 1n;
    samples = 0;
    begun = Date.now();
  };
  const tick = setInterval(() => {
    if (seq === 0n && samples < 0) return;
    const next = samples === 0 ? 1 : samples * 2;
    if (next > 2048 || socket.bufferedAmount > 0) return;
    if (Date.now() - begun < next * 12 && next > 1) return;
    samples = next;
    const moving = samples <= 2 ? 2 : 1;
    const [width, height] = [Math.round(size.width / moving), Math.round(size.height / moving)];
    const data = draw(session.scene, Math.min(width, 900), Math.min(height, Math.round((900 * height) / width)), samples);
    say({ case: "frame", value: { $typeName: "diaphane.v1.Frame", codec: Codec.JPEG, key: true, epoch, seq: ++seq, inputSeq: session.input_seq, iteration: BigInt(samples), error: samples < 2 ? Infinity : 0.35 / Math.sqrt(samples), width, height, renderUs: BigInt((Date.now() - begun) * 1000 + 4000), encodeUs: 900n, denoised: samples <= 4, decoder: "", quality: moving === 1 ? FrameQuality.SETTLED : FrameQuality.MOVING, data } });
    say({ case: "stats", value: { $typeName: "diaphane.v1.Stats", samplesPerSecond: 61.3, sessions: 1, droppedSamples: 0n, framesSkipped: 0n } });
    if (samples >= 2048) say({ case: "state", value: { $typeName: "diaphane.v1.State", epoch, converged: true, lossless: false, biased: false } });
  }, 30);
  samples = -1;
  socket.on("close", () => clearInterval(tick));
  socket.on("message", (raw) => {
    const { body } = fromBinary(ClientMessageSchema, new Uint8Array(raw as Buffer));
    if (body.case === "hello") {
      size = body.value.viewport ?? size;
      say({ case: "config", value: { $typeName: "diaphane.v1.Config", protocol: 1, sessionId: "s", codec: Codec.JPEG, engine: "cpu", device: "2 CPU threads", scene: session.scene, inputSeq: session.input_seq, follower: false,
        presets: Object.keys(colours).map((name) => ({ $typeName: "diaphane.v1.Preset" as const, name, scene: scene_named(name) })) } });
      restart();
    } else if (body.case === "scene") {
      session.input_seq = body.value.inputSeq;
      if (body.value.scene) session.scene = body.value.scene;
      if (body.value.viewport) size = body.value.viewport;
      restart();
    }
  });
}
