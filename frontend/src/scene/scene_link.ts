import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { SceneSchema, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { mostMarks } from "../marks/mark";
import { annotationsFromBytes, annotationsToBytes, type Annotations } from "../protocol/mark_messages";
import { mostPresented } from "../slices/presented";
import { readAtMost, type StreamEnd } from "../streams";
import { patternOf, setTexture, textureOf, type TextureFiles } from "./textures";
import { longestName } from "./transfer";

/**
 * A scene in the fragment of a URL, which servers never see: the version, a dot, and deflated
 * Protobuf in base64url. Marks and measurements may follow after another dot.
 */
const version = 1;
const pattern = /^#view=(\d{1,4})\.([A-Za-z0-9_-]+)(?:\.([A-Za-z0-9_-]+))?$/;
/** Maximum length of the fragment, so that mail programs and messengers keep the URL intact. */
const mostText = 8192;
/** Limit of the inflated scene. The server accepts 64 KB. */
const mostBytes = 65_536;

export type LinkedScene =
  | { readonly kind: "none" | "damaged" | "newer" }
  | { readonly kind: "scene"; readonly scene: Scene; readonly annotations: Annotations | null };

/** A link refers to a built-in pattern by its name instead of containing its file. */
const reference = "pattern:";

/** Replaces the files of all textures. A light whose texture has no replacement loses it. */
function withFiles(scene: Scene, replace: (file: Uint8Array) => Uint8Array<ArrayBuffer> | undefined): Scene {
  return scene.lights.reduce((changed, light, i) => {
    const file = textureOf(light);
    if (!file) return changed;
    return setTexture(changed, i, replace(file) ?? null, light.shape.value?.texture?.projectionDegrees);
  }, scene);
}

/** Limits names to the length that the page accepts, because others can write links as well. */
const withShortNames = (scene: Scene): Scene => {
  const short = <Named extends { name: string }>(one: Named): Named => ({
    ...one,
    name: one.name.slice(0, longestName),
  });
  const { transferFunction } = scene;
  return {
    ...scene,
    lights: scene.lights.map(short),
    ...(transferFunction
      ? { transferFunction: { ...transferFunction, channels: transferFunction.channels.map(short) } }
      : {}),
  };
};

/**
 * Returns the fragment with its #, or null if the scene is too large for a URL. The user's own images are left out.
 * `files` are those of the built-in patterns.
 */
export async function linkOf(
  scene: Scene,
  files: TextureFiles,
  annotations: Annotations | null = null,
): Promise<string | null> {
  const referring = withFiles(scene, (file) => {
    const name = patternOf(files, file);
    return name && new TextEncoder().encode(reference + name);
  });
  const bytes = toBinary(SceneSchema, create(SceneSchema, withShortNames(referring)));
  if (bytes.length > mostBytes) return null;
  const { bytes: packed, end } = await through(bytes, new CompressionStream("deflate-raw"), mostText);
  const marks =
    annotations && (await through(annotationsToBytes(annotations), new CompressionStream("deflate-raw"), mostText));
  const text = `#view=${version}.${base64url(packed)}${marks ? `.${base64url(marks.bytes)}` : ""}`;
  return end !== "whole" || text.length > mostText ? null : text;
}

/**
 * Parses the fragment of a URL, which may be any text. The renderer decides whether the scene is
 * valid.
 */
export async function sceneOfLink(hash: string, files: TextureFiles): Promise<LinkedScene> {
  if (!hash.startsWith("#view=")) return { kind: "none" };
  const [, linkVersion = "", text = "", marks = ""] = pattern.exec(hash) ?? [];
  if (linkVersion !== "" && Number(linkVersion) > version) return { kind: "newer" };
  if (Number(linkVersion) !== version || hash.length > mostText) return { kind: "damaged" };
  try {
    const { bytes, end } = await through(bytesOf(text), new DecompressionStream("deflate-raw"), mostBytes);
    if (end !== "whole") return { kind: "damaged" };
    const scene = fromBinary(SceneSchema, bytes);
    const isComplete = scene.camera?.eye && scene.camera.target && scene.transferFunction;
    if (!isComplete) return { kind: "damaged" };
    const byReference = new Map([...files].map(([name, file]) => [reference + name, file]));
    const complete = withFiles(scene, (text) => byReference.get(new TextDecoder().decode(text)));
    return { kind: "scene", scene: withShortNames(complete), annotations: await annotationsIn(marks) };
  } catch {
    return { kind: "damaged" };
  }
}

async function annotationsIn(text: string): Promise<Annotations | null> {
  if (text === "") return null;
  const { bytes, end } = await through(bytesOf(text), new DecompressionStream("deflate-raw"), mostBytes);
  if (end !== "whole") throw new Error("too large");
  const { marks, measures } = annotationsFromBytes(bytes);
  return { marks: marks.slice(0, mostMarks), measures: measures.slice(0, mostPresented) };
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
