import { useState } from "preact/hooks";
import type { Scene, Viewport } from "../../../protocol/messages";
import { t } from "../../../texts";
import { longestLargeSide } from "../../../video/file_shot";
import { renderersError, shortestSide } from "../../../video/still_shot";
import type { ViewerSession } from "../../../video/viewer_session";
import { Choice } from "../../choice";
import { Field } from "../../field";
import { DrawMarks } from "../../marks/draw_marks";
import { fileMarksOf } from "../../marks/file_marks";
import { decorated, decorationOf, marksInPicture } from "../../marks/in_pictures";
import { saveFile } from "./save_file";
import type { ExportOrder } from "./shot";
import { isHeldByPage, large, largest, poster, typedSize } from "./shot_size";
import { TakeForm } from "./take_form";

/** The estimated relative error at which a picture is finished; 0 renders until the renderer itself stops. */
const errors = { quick: 0.05, good: 0.02, best: 0 } as const;
type QualityName = keyof typeof errors;
type NamedSize = Exclude<keyof typeof t.take.sizes, "other">;
type SizeName = NamedSize | "other";
const namedSizes = ["screen", "large", "largest", "poster"] as const satisfies readonly NamedSize[];

export interface PictureFormProps {
  readonly session: ViewerSession;
  /** Whether other sizes can be rendered. */
  readonly rendered: boolean;
  readonly busy: boolean;
  readonly onExport: (order: ExportOrder) => void;
}

/** The form for the picture on the screen, which is saved at once, and for one of any other size. */
export function PictureForm(props: PictureFormProps) {
  const text = t.take;
  const form = usePictureForm(props);
  const waits = props.busy && form.size !== "screen";
  return (
    <TakeForm onSubmit={form.submit}>
      {props.rendered ? <SizeChoice form={form} /> : null}
      {form.size === "screen" ? (
        <p class="muted">{text.pictureNow}</p>
      ) : (
        <>
          <Choice
            label={text.quality}
            value={form.quality}
            options={Object.entries(text.qualities)}
            onChoose={(name) => form.setQuality(name as QualityName)}
          />
          <p class="muted">
            {text.pictureLead} {text.timeHint}
          </p>
        </>
      )}
      <DrawMarks session={props.session} on={form.withMarks} change={form.setWithMarks} />
      <p>
        <button type="submit" class="button button-main" disabled={waits}>
          {waits ? text.ofPicture.rendering : text.save}
        </button>
      </p>
      <p role="status">{form.size === "screen" && form.saved !== null ? text.ofPicture[form.saved] : ""}</p>
    </TakeForm>
  );
}

function SizeChoice({ form }: { readonly form: ReturnType<typeof usePictureForm> }) {
  const text = t.take;
  return (
    <>
      <Choice
        label={text.size}
        value={form.size}
        options={[
          ...namedSizes.map((name): [string, string] => {
            const { width, height } = form.sizes[name];
            return [name, text.sizes[name](width, height)];
          }),
          ["other", text.sizes.other],
        ]}
        onChoose={(name) => form.setSize(name as SizeName)}
      />
      {form.size === "other" ? <OtherSize typed={form.typed} onType={form.setTyped} wrong={form.wrong} /> : null}
    </>
  );
}

interface TypedSides {
  readonly width: string;
  readonly height: string;
}

/**
 * The entries of the form and their order. A picture that the page can hold is rendered as a still.
 * A worker makes larger ones as a file.
 */
function usePictureForm({ session, onExport }: PictureFormProps) {
  const screen = session.viewport;
  const [size, setSize] = useState<SizeName>("screen");
  const [quality, setQuality] = useState<QualityName>("good");
  const [typed, setTyped] = useState<TypedSides>(() => ({
    width: String(screen.width),
    height: String(screen.height),
  }));
  const [wrong, setWrong] = useState(false);
  const [saved, setSaved] = useState<"saved" | "failed" | null>(null);
  const [withMarks, setWithMarks] = useState(true); // as on the screen
  const sizes: Readonly<Record<NamedSize, Viewport>> = {
    screen,
    large: large(screen),
    largest: largest(screen),
    poster: poster(screen),
  };
  const drawn = () => withMarks && marksInPicture(session).length > 0;
  const saveScreen = async () => {
    const png = await session.pictures.png();
    if (png) saveFile(drawn() ? await decorated(png, decorationOf(session, true)) : png);
    setSaved(png ? "saved" : "failed");
  };
  const submit = () => {
    if (size === "screen") {
      void saveScreen();
      return;
    }
    const chosen = size === "other" ? typedSize(typed.width, typed.height) : sizes[size];
    const scene = session.editor.scene.value;
    setWrong(chosen === null);
    if (!chosen || !scene) return;
    const error = errors[quality];
    if (isHeldByPage(chosen)) {
      const decoration = drawn() ? { decorate: decorationOf(session) } : {};
      onExport({ kind: "still", scene, size: chosen, error, ...decoration });
    } else void saveLarge(scene, chosen, error);
  };
  const saveLarge = async (scene: Scene, chosen: Viewport, error: number) => {
    const marks = drawn() ? { marks: await fileMarksOf(session, chosen) } : {};
    onExport({ kind: "picture", keys: [scene], size: chosen, error: error || renderersError, ...marks });
  };
  return {
    sizes,
    size,
    setSize,
    quality,
    setQuality,
    typed,
    setTyped,
    wrong,
    saved,
    submit,
    withMarks,
    setWithMarks,
  };
}

interface OtherSizeProps {
  readonly typed: TypedSides;
  readonly onType: (typed: TypedSides) => void;
  readonly wrong: boolean;
}

function OtherSize({ typed, onType, wrong }: OtherSizeProps) {
  const text = t.take;
  return (
    <>
      <div class="take-sides">
        <Field
          label={text.width}
          value={typed.width}
          onInput={(width) => onType({ ...typed, width })}
          digits
          most={6}
        />
        <Field
          label={text.height}
          value={typed.height}
          onInput={(height) => onType({ ...typed, height })}
          digits
          most={6}
        />
      </div>
      {wrong ? (
        <p class="field-fault" role="alert">
          {text.wrongSize(shortestSide, longestLargeSide)}
        </p>
      ) : (
        <p class="field-hint">{text.otherHint}</p>
      )}
    </>
  );
}
