import { useEffect, useState } from "preact/hooks";
import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import { set_texture, texture_fits, texture_names, texture_of, type TextureName } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { read_picture, texture_file } from "./texture_files";

export interface TexturePartProps {
  readonly session: ViewerSession;
  readonly light: Light;
  readonly index: number;
}

/** What a light shines through: none, one of a few made here, or a picture of one's own. */
export function TexturePart({ session, light, index }: TexturePartProps) {
  const text = t.settings.light.texture;
  const [fault, set_fault] = useState("");
  const [known, set_known] = useState<ReadonlyMap<TextureName, Uint8Array<ArrayBuffer>>>(new Map());
  const names = texture_names(light);
  const now = texture_of(light);
  useEffect(() => {
    let here = true;
    void Promise.all(names.map(async (name) => [name, await texture_file(name)] as const)).then((files) => {
      if (here) set_known(new Map(files));
    });
    return () => {
      here = false;
    };
  }, [names]);
  const chosen = now && [...known].find(([, bytes]) => same(bytes, now))?.[0];
  const put = (bytes: Uint8Array<ArrayBuffer> | null) => {
    const scene = session.scene.value;
    const fits = bytes === null || (scene !== null && texture_fits(scene, index, bytes.length));
    set_fault(fits ? "" : text.no_room);
    if (!fits) return;
    session.change(`light texture ${index}`, (before) => set_texture(before, index, bytes));
    session.rest();
  };
  const own = async (input: HTMLInputElement) => {
    const file = input.files?.[0];
    input.value = ""; // so that the same can be chosen again
    if (!file) return;
    const read = await read_picture(file);
    if ("bytes" in read) put(read.bytes);
    else set_fault(text[read.refused]);
  };
  return (
    <div class="textures" role="group" aria-label={text.title}>
      <span class="control-name" aria-hidden="true">{text.title}</span>
      <div class="texture-row">
        <button type="button" class="texture" aria-pressed={now === null} onClick={() => put(null)}><span class="texture-none" aria-hidden="true" />{text.none}</button>
        {names.map((name) => (
          <button key={name} type="button" class="texture" aria-pressed={chosen === name} onClick={() => void texture_file(name).then(put)}>
            <Swatch file={known.get(name)} />{text.names[name]}
          </button>
        ))}
        <label class="texture texture-own" data-chosen={now !== null && known.size > 0 && !chosen ? "" : undefined}>
          <span class="texture-none" aria-hidden="true">+</span>{text.own}
          <input type="file" class="visually-hidden" accept="image/*" aria-label={text.own_label} onChange={(event) => void own(event.currentTarget)} />
        </label>
      </div>
      {fault ? <p class="field-fault" role="alert">{fault}</p> : null}
    </div>
  );
}

function Swatch({ file }: { readonly file: Uint8Array<ArrayBuffer> | undefined }) {
  const [url, set_url] = useState("");
  useEffect(() => {
    if (!file) return;
    const made = URL.createObjectURL(new Blob([file], { type: "image/png" }));
    set_url(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  return url ? <img src={url} alt="" /> : <span class="texture-none" aria-hidden="true" />;
}

const same = (a: Uint8Array, b: Uint8Array): boolean => a.length === b.length && a.every((byte, i) => byte === b[i]);
