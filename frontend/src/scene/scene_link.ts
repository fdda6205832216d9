import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { SceneSchema, type Light, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { readAtMost, type StreamEnd } from "../streams";

/** A scene in the fragment of a URL, which servers never see: version, point, deflated Protobuf in base64url. */
const version = 1;
const pattern = /^#view=(\d{1,4})\.([A-Za-z0-9_-]+)$/;
/** Maximum length of the URL that mail programs and messengers keep intact. */
const mostText = 8192;
/** Limit of the inflated scene. The server accepts 64 KB. */
const mostBytes = 65_536;

export type LinkedScene =
  { readonly kind: "none" | "damaged" | "newer" } | { readonly kind: "scene"; readonly scene: Scene };

/** Removes names, which the user typed, and images, which the user chose. */
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

/** Returns the fragment with its #, or null if the scene is too large for a URL. */
export async function linkOf(scene: Scene): Promise<string | null> {
  const bytes = toBinary(SceneSchema, create(SceneSchema, withoutWords(scene)));
  if (bytes.length > mostBytes) return null;
  const { bytes: packed, end } = await through(bytes, new CompressionStream("deflate-raw"), mostText);
  const text = `#view=${version}.${base64url(packed)}`;
  return end !== "whole" || text.length > mostText ? null : text;
}

/** Accepts any text. Whether the scene is valid is for the renderer to decide. */
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
