import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { SceneSchema, type Light, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { readAtMost, type StreamEnd } from "../streams";

/** A scene as it stands behind the # of an address, where no server sees it: version, point, deflated Protobuf in base64url. */
const version = 1;
const pattern = /^#view=(\d{1,4})\.([A-Za-z0-9_-]+)$/;
/** Of the address: what mails and messengers still carry whole. */
const mostText = 8192;
/** Unpacked. The server takes 64 KB of a scene. */
const mostBytes = 65_536;

export type LinkedScene =
  { readonly kind: "none" | "damaged" | "newer" } | { readonly kind: "scene"; readonly scene: Scene };

/** Names are what a person typed, and pictures what a person chose: neither goes along. */
function withoutWords(scene: Scene): Scene {
  const bare = (light: Light): Light => {
    const shape = light.shape.case
      ? { ...light.shape, value: { ...light.shape.value, texture: undefined } }
      : light.shape;
    return { ...light, name: "", shape } as Light;
  };
  return {
    ...scene,
    lights: scene.lights.map(bare),
    ...(scene.transferFunction
      ? {
          transferFunction: {
            ...scene.transferFunction,
            channels: scene.transferFunction.channels.map((channel) => ({ ...channel, name: "" })),
          },
        }
      : {}),
  };
}

/** What stands behind the path, with its #; nothing where the scene is too large for an address. */
export async function linkOf(scene: Scene): Promise<string | null> {
  const bytes = toBinary(SceneSchema, create(SceneSchema, withoutWords(scene)));
  if (bytes.length > mostBytes) return null;
  const { bytes: packed, end } = await through(bytes, new CompressionStream("deflate-raw"), mostText);
  const text = `#view=${version}.${base64url(packed)}`;
  return end !== "whole" || text.length > mostText ? null : text;
}

/** Of any text at all. A scene that is none of the renderer's is its to refuse. */
export async function sceneOfLink(hash: string): Promise<LinkedScene> {
  if (!hash.startsWith("#view=")) return { kind: "none" };
  const [, said = "", text = ""] = pattern.exec(hash) ?? [];
  if (said !== "" && Number(said) > version) return { kind: "newer" };
  if (Number(said) !== version || hash.length > mostText) return { kind: "damaged" };
  try {
    const { bytes, end } = await through(bytesOf(text), new DecompressionStream("deflate-raw"), mostBytes);
    if (end !== "whole") return { kind: "damaged" };
    const scene = fromBinary(SceneSchema, bytes);
    const whole = scene.camera?.eye && scene.camera.target && scene.transferFunction;
    return whole ? { kind: "scene", scene: withoutWords(scene) } : { kind: "damaged" };
  } catch {
    return { kind: "damaged" };
  }
}

const through = (
  bytes: Uint8Array<ArrayBuffer>,
  packer: CompressionStream | DecompressionStream,
  most: number,
): Promise<StreamEnd> => readAtMost(new Blob([bytes]).stream().pipeThrough(packer), most);

const base64url = (bytes: Uint8Array): string =>
  btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""))
    .replaceAll("+", "-")
    .replaceAll("/", "_")
    .replaceAll("=", "");

const bytesOf = (text: string): Uint8Array<ArrayBuffer> =>
  Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
