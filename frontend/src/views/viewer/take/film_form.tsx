import { useEffect, useRef, useState } from "preact/hooks";
import type { PresetInfo } from "../../../api/types";
import type { FileOrder } from "../../../protocol/file_messages";
import { t } from "../../../texts";
import { longest_film_s } from "../../../video/file_shot";
import type { ViewerSession } from "../../../video/viewer_session";
import { Choice } from "../../choice";
import { Field } from "../../field";
import { fault as faulty } from "../../form";
import { useApp } from "../../state";
import { scene_of_preset } from "../preset_scene";
import { film_order, film_rates, film_sides, film_size, most_key_views, typed_seconds } from "./film_size";

const errors = { quick: 0.05, good: 0.02 } as const;

export interface FilmFormProps {
  readonly session: ViewerSession;
  readonly kind: "turntable" | "tour";
  readonly busy: boolean;
  readonly onTake: (order: FileOrder) => void;
}

export function FilmForm({ session, kind, busy, onTake }: FilmFormProps) {
  const app = useApp();
  const text = t.take;
  const [size, set_size] = useState<keyof typeof film_sides>("medium");
  const [quality, set_quality] = useState<keyof typeof errors>("quick");
  const [seconds, set_seconds] = useState("8");
  const [rate, set_rate] = useState("25");
  const [views, set_views] = useState<readonly View[]>([]);
  const [fault, set_fault] = useState("");
  const [wrong_seconds, set_wrong_seconds] = useState("");
  const form = useRef<HTMLFormElement>(null);
  const [preparing, set_preparing] = useState(false);
  const here = useRef(true);
  useEffect(() => () => {
    here.current = false;
  }, []);
  // Once it is on the page: to what has to be mended, where its fault is read out.
  useEffect(() => {
    if (wrong_seconds) form.current?.querySelector<HTMLElement>("[aria-invalid]")?.focus();
  }, [wrong_seconds]);
  const count = typed_seconds(seconds);
  const sized = (name: keyof typeof film_sides) => film_size(session.viewport, film_sides[name]);
  /** What was wrong is being mended. */
  const answered = <T,>(set: (value: T) => void) => (value: T) => {
    set_fault("");
    set_wrong_seconds("");
    set(value);
  };
  const submit = async () => {
    set_fault("");
    set_wrong_seconds("");
    const scene = session.scene.value;
    if (!scene) return;
    if (count === null) { set_wrong_seconds(text.wrong_seconds(longest_film_s)); return; }
    const chosen = views.filter((view) => view.taken);
    if (kind === "tour" && (chosen.length < 2 || chosen.length > most_key_views)) { set_fault(text.wrong_views(most_key_views)); return; }
    set_preparing(true);
    try {
      const keys = kind === "tour" ? await Promise.all(chosen.map(async ({ preset }) => (preset ? await scene_of_preset(app.api.presets, preset.id) : scene))) : [scene];
      if (here.current) onTake(film_order({ kind, keys, size: sized(size), seconds: count, rate: Number(rate), error: errors[quality] }));
    } catch (thrown) {
      set_fault(app.explain(thrown));
    }
    set_preparing(false);
  };
  return (
    <form ref={form} class="take-form" noValidate onSubmit={(event) => {
      event.preventDefault();
      void submit();
    }}>
      <p class="muted">{kind === "tour" ? text.tour_lead : text.turntable_lead}</p>
      {kind === "tour" && session.data_set_id !== null ? <ViewList data_set_id={session.data_set_id} views={views} onViews={answered(set_views)} onFault={set_fault} /> : null}
      <div class="take-sides">
        <Field label={text.seconds} value={seconds} onInput={answered(set_seconds)} digits most={3} {...faulty(wrong_seconds)} />
        <Choice label={text.rate} value={rate} options={film_rates.map((n) => [String(n), String(n)])} onChoose={set_rate} />
      </div>
      <Choice label={text.size} value={size} options={(["small", "medium", "large"] as const).map((name) => [name, text.film_sizes[name](sized(name).width, sized(name).height)])}
        onChoose={(name) => set_size(name as keyof typeof film_sides)} />
      <Choice label={text.quality} value={quality} options={(["quick", "good"] as const).map((name) => [name, text.qualities[name]])}
        onChoose={(name) => set_quality(name as keyof typeof errors)} />
      {fault ? <p class="field-fault" role="alert">{fault}</p> : <p class="field-hint">{text.film_hint(count === null ? 0 : count * Number(rate))}</p>}
      <p><button type="submit" class="button button-main" disabled={busy || preparing}>{busy ? text.of_film.rendering : text.save_film}</button></p>
    </form>
  );
}

/** A place that a tour comes by: as the picture is now, or as a saved look shows the scan. */
interface View {
  readonly preset: PresetInfo | null;
  readonly taken: boolean;
}

interface ViewListProps {
  readonly data_set_id: string;
  readonly views: readonly View[];
  readonly onViews: (views: readonly View[]) => void;
  readonly onFault: (fault: string) => void;
}

function ViewList({ data_set_id, views, onViews, onFault }: ViewListProps) {
  const app = useApp();
  const text = t.take;
  useEffect(() => {
    let current = true;
    app.api.presets.list(data_set_id).then(
      (list) => {
        if (current) onViews([null, ...list].map((preset, n) => ({ preset, taken: n < most_key_views })));
      },
      (thrown: unknown) => {
        if (current) onFault(app.explain(thrown));
      },
    );
    return () => {
      current = false;
    };
  }, [app, data_set_id]);
  const name = (view: View) => view.preset?.name ?? text.view_now;
  const up = (n: number) => {
    const view = views[n];
    const above = views[n - 1];
    if (view && above) onViews([...views.slice(0, n - 1), view, above, ...views.slice(n + 1)]);
  };
  return (
    <fieldset class="take-views">
      <legend>{text.views}</legend>
      {views.length === 1 ? <p class="field-hint">{text.no_views}</p> : null}
      <ol>
        {views.map((view, n) => (
          <li key={view.preset?.id ?? ""}>
            <label>
              <input type="checkbox" checked={view.taken} onChange={(event) => onViews(views.map((one, i) => (i === n ? { ...one, taken: event.currentTarget.checked } : one)))} />
              {name(view)}
            </label>
            <button type="button" class="button button-small" aria-label={text.earlier_of(name(view))} aria-disabled={n === 0} onClick={() => up(n)}>{text.earlier}</button>
          </li>
        ))}
      </ol>
    </fieldset>
  );
}
