import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import {
  patternOf,
  projectionFor,
  setTexture,
  textureFits,
  textureNames,
  textureOf,
  type TextureFiles,
  type TextureName,
} from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { readPicture, textureFile, textureFiles } from "./texture_files";

export interface TexturePartProps {
  readonly session: ViewerSession;
  readonly light: Light;
  readonly index: number;
}

/** The pattern of a light: none, a built-in one, or the user's own image. */
export function TexturePart({ session, light, index }: TexturePartProps) {
  const text = t.settings.light.texture;
  const [fault, setFault] = useState("");
  const names = textureNames(light);
  const files = useTextureFiles(names);
  const now = textureOf(light);
  const chosen = now && patternOf(files, now);
  const put = (bytes: Uint8Array<ArrayBuffer> | null, name?: TextureName) => {
    const scene = session.editor.scene.value;
    const fits = bytes === null || (scene !== null && textureFits(scene, index, bytes.length));
    setFault(fits ? "" : text.noRoom);
    if (!fits) return;
    session.editor.change(`light texture ${index}`, (before) =>
      setTexture(before, index, bytes, projectionFor(before, light, name)),
    );
    session.editor.rest();
  };
  return (
    <TextureRow title={text.title} fault={fault}>
      <button type="button" class="texture" aria-pressed={now === null} onClick={() => put(null)}>
        <span class="texture-none" aria-hidden="true" />
        {text.none}
      </button>
      {names.map((name) => (
        <button
          key={name}
          type="button"
          class="texture"
          aria-pressed={chosen === name}
          onClick={() => void textureFile(name).then((file) => put(file, name))}
        >
          <Swatch file={files.get(name)} />
          {text.names[name]}
        </button>
      ))}
      <OwnTexture chosen={now !== null && files.size > 0 && !chosen} onRead={put} onFault={setFault} />
    </TextureRow>
  );
}

export interface TextureRowProps {
  readonly title: string;
  readonly fault: string;
  readonly hint?: string;
  readonly children: ComponentChildren;
}

/** Pictures to choose from, under a title, and what is wrong with the last choice. */
export function TextureRow({ title, fault, hint, children }: TextureRowProps) {
  return (
    <div class="textures" role="group" aria-label={title}>
      <span class="control-name" aria-hidden="true">
        {title}
      </span>
      <div class="texture-row">{children}</div>
      {hint ? <p class="hint">{hint}</p> : null}
      {fault ? (
        <p class="field-fault" role="alert">
          {fault}
        </p>
      ) : null}
    </div>
  );
}

/** The built-in patterns as image files. Empty until all of them are ready. */
function useTextureFiles(names: readonly TextureName[]): TextureFiles {
  const [files, setFiles] = useState<TextureFiles>(new Map());
  useEffect(() => {
    let here = true;
    void textureFiles(names).then((made) => {
      if (here) setFiles(made);
    });
    return () => {
      here = false;
    };
  }, [names]);
  return files;
}

interface OwnTextureProps {
  readonly chosen: boolean;
  readonly onRead: (bytes: Uint8Array<ArrayBuffer>) => void;
  readonly onFault: (fault: string) => void;
}

/** Reads the image file that the user chooses. */
function OwnTexture({ chosen, onRead, onFault }: OwnTextureProps) {
  const text = t.settings.light.texture;
  const read = async (input: HTMLInputElement) => {
    const file = input.files?.[0];
    input.value = ""; // so that the same file can be chosen again
    if (!file) return;
    const picture = await readPicture(file);
    if ("bytes" in picture) onRead(picture.bytes);
    else onFault(text[picture.refused]);
  };
  return (
    <label class="texture texture-own" data-chosen={chosen ? "" : undefined}>
      <span class="texture-none" aria-hidden="true">
        +
      </span>
      {text.own}
      <input
        type="file"
        class="visually-hidden"
        accept="image/*"
        aria-label={text.ownLabel}
        onChange={(event) => void read(event.currentTarget)}
      />
    </label>
  );
}

export function Swatch({ file }: { readonly file: Uint8Array<ArrayBuffer> | undefined }) {
  const [url, setUrl] = useState("");
  useEffect(() => {
    if (!file) return;
    const made = URL.createObjectURL(new Blob([file], { type: "image/png" }));
    setUrl(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  return url ? <img src={url} alt="" /> : <span class="texture-none" aria-hidden="true" />;
}
