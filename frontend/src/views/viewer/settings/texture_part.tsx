import { useEffect, useState } from "preact/hooks";
import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import { setTexture, textureFits, textureNames, textureOf, type TextureName } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { readPicture, textureFile } from "./texture_files";

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
  const chosen = now && [...files].find(([, bytes]) => same(bytes, now))?.[0];
  const put = (bytes: Uint8Array<ArrayBuffer> | null) => {
    const scene = session.editor.scene.value;
    const fits = bytes === null || (scene !== null && textureFits(scene, index, bytes.length));
    setFault(fits ? "" : text.noRoom);
    if (!fits) return;
    session.editor.change(`light texture ${index}`, (before) => setTexture(before, index, bytes));
    session.editor.rest();
  };
  return (
    <div class="textures" role="group" aria-label={text.title}>
      <span class="control-name" aria-hidden="true">
        {text.title}
      </span>
      <div class="texture-row">
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
            onClick={() => void textureFile(name).then(put)}
          >
            <Swatch file={files.get(name)} />
            {text.names[name]}
          </button>
        ))}
        <OwnTexture chosen={now !== null && files.size > 0 && !chosen} onRead={put} onFault={setFault} />
      </div>
      {fault ? (
        <p class="field-fault" role="alert">
          {fault}
        </p>
      ) : null}
    </div>
  );
}

type TextureFiles = ReadonlyMap<TextureName, Uint8Array<ArrayBuffer>>;

/** The built-in patterns as image files. Empty until all of them are ready. */
function useTextureFiles(names: readonly TextureName[]): TextureFiles {
  const [files, setFiles] = useState<TextureFiles>(new Map());
  useEffect(() => {
    let here = true;
    void Promise.all(names.map(async (name) => [name, await textureFile(name)] as const)).then((made) => {
      if (here) setFiles(new Map(made));
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

function Swatch({ file }: { readonly file: Uint8Array<ArrayBuffer> | undefined }) {
  const [url, setUrl] = useState("");
  useEffect(() => {
    if (!file) return;
    const made = URL.createObjectURL(new Blob([file], { type: "image/png" }));
    setUrl(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  return url ? <img src={url} alt="" /> : <span class="texture-none" aria-hidden="true" />;
}

const same = (a: Uint8Array, b: Uint8Array): boolean => a.length === b.length && a.every((byte, i) => byte === b[i]);
