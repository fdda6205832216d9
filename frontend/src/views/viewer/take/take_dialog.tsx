import { useEffect, useState } from "preact/hooks";
import type { Viewport } from "../../../protocol/messages";
import { link_of } from "../../../scene/scene_link";
import { t } from "../../../texts";
import { longest_large_side } from "../../../video/file_shot";
import { renderers_error, shortest_side } from "../../../video/still_shot";
import type { ViewerSession } from "../../../video/viewer_session";
import { Choice } from "../../choice";
import { Dialog } from "../../dialog";
import { Field } from "../../field";
import { Icon } from "../../icons";
import { FilmForm } from "./film_form";
import { save_file } from "./save_file";
import type { TakeOrder } from "./shot";
import { is_held_by_page, large, largest, poster, typed_size } from "./shot_size";

export interface TakeDialogProps {
  readonly session: ViewerSession;
  /** A picture of any size can be rendered: it is a scan that this person may open. */
  readonly rendered: boolean;
  /** One is being rendered already. */
  readonly busy: boolean;
  readonly onTake: (order: TakeOrder) => void;
  readonly onClose: () => void;
}

export function TakeDialog({ session, rendered, busy, onTake, onClose }: TakeDialogProps) {
  const text = t.take;
  const [what, set_what] = useState<keyof typeof text.kinds>("picture");
  return (
    <Dialog title={text.title} onClose={onClose}>
      <section class="share-part" aria-labelledby="take-picture">
        <h3 id="take-picture">{rendered ? text.file : text.picture}</h3>
        {rendered ? <Choice label={text.what} value={what} options={Object.entries(text.kinds)} onChoose={(kind) => set_what(kind as typeof what)} /> : null}
        {!rendered ? <PictureNow session={session} /> : what === "picture" ? <PictureForm session={session} busy={busy} onTake={onTake} /> : (
          <FilmForm key={what} session={session} kind={what} busy={busy} onTake={onTake} />
        )}
      </section>
      {session.data_set_id !== null ? (
        <section class="share-part" aria-labelledby="take-link">
          <h3 id="take-link">{text.link}</h3>
          <LinkPart session={session} data_set_id={session.data_set_id} />
        </section>
      ) : null}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>{t.close}</button>
      </div>
    </Dialog>
  );
}

const errors = { quick: 0.05, good: 0.02, best: 0 } as const;
type QualityName = keyof typeof errors;
type SizeName = keyof typeof t.take.sizes;

function PictureForm({ session, busy, onTake }: Pick<TakeDialogProps, "session" | "busy" | "onTake">) {
  const text = t.take;
  const screen = session.viewport;
  const [size, set_size] = useState<SizeName>("screen");
  const [quality, set_quality] = useState<QualityName>("good");
  const [width, set_width] = useState(String(screen.width));
  const [height, set_height] = useState(String(screen.height));
  const [wrong, set_wrong] = useState(false);
  const sizes: Readonly<Record<Exclude<SizeName, "other">, Viewport>> = { screen, large: large(screen), largest: largest(screen), poster: poster(screen) };
  const named = (name: Exclude<SizeName, "other">) => [name, text.sizes[name](sizes[name].width, sizes[name].height)] as const;
  const submit = () => {
    const chosen = size === "other" ? typed_size(width, height) : sizes[size];
    const scene = session.scene.value;
    set_wrong(chosen === null);
    if (!chosen || !scene) return;
    const error = errors[quality];
    if (is_held_by_page(chosen)) onTake({ kind: "still", scene, size: chosen, error });
    else onTake({ kind: "picture", keys: [scene], size: chosen, error: error || renderers_error });
  };
  return (
    <form class="take-form" noValidate onSubmit={(event) => {
      event.preventDefault();
      submit();
    }}>
      <p class="muted">{text.picture_lead}</p>
      <Choice label={text.size} value={size} options={[named("screen"), named("large"), named("largest"), named("poster"), ["other", text.sizes.other]]}
        onChoose={(name) => set_size(name as SizeName)} />
      {size === "other" ? (
        <>
          <div class="take-sides">
            <Field label={text.width} value={width} onInput={set_width} digits most={6} />
            <Field label={text.height} value={height} onInput={set_height} digits most={6} />
          </div>
          {wrong ? <p class="field-fault" role="alert">{text.wrong_size(shortest_side, longest_large_side)}</p> : <p class="field-hint">{text.other_hint}</p>}
        </>
      ) : null}
      <Choice label={text.quality} value={quality} options={Object.entries(text.qualities)} onChoose={(name) => set_quality(name as QualityName)} />
      <p class="field-hint">{text.time_hint}</p>
      <p><button type="submit" class="button button-main" disabled={busy}>{busy ? text.of_picture.rendering : text.save}</button></p>
    </form>
  );
}

/** Of somebody else's session: what is on the screen. */
function PictureNow({ session }: Pick<TakeDialogProps, "session">) {
  return (
    <>
      <p class="muted">{t.take.picture_now}</p>
      <p><button type="button" class="button button-main" onClick={() => void session.png().then((png) => png && save_file(png))}>{t.take.save}</button></p>
    </>
  );
}

function LinkPart({ session, data_set_id }: Pick<TakeDialogProps, "session"> & { readonly data_set_id: string }) {
  const text = t.take;
  const scene = session.scene.value;
  const [url, set_url] = useState<string | null>("");
  const [said, set_said] = useState("");
  useEffect(() => {
    let current = true;
    if (scene) void link_of(scene).then((hash) => {
      if (current) set_url(hash === null ? null : `${location.origin}/view/${data_set_id}${hash}`);
    });
    return () => {
      current = false;
    };
  }, [scene, data_set_id]);
  if (url === null) return <p>{text.link_too_large}</p>;
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(url);
      set_said(text.copied);
    } catch {
      set_said(text.not_copied); // not allowed, or no safe connection
    }
  };
  return (
    <div class="share-link">
      <p class="muted">{text.link_lead}</p>
      <div class="share-row">
        <input type="text" readOnly value={url} aria-label={text.link_field} onFocus={(event) => event.currentTarget.select()} />
        <button type="button" class="button" onClick={() => void copy()}><Icon name="copy" />{text.copy}</button>
      </div>
      <p class="muted" role="status">{said}</p>
    </div>
  );
}
