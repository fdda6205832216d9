import { useEffect, useRef, useState } from "preact/hooks";
import type { Study } from "../../api/studies";
import type { OrderStep, View } from "../../studies/definition";
import { takePictures, type Taking } from "../../studies/take_pictures";
import { t } from "../../texts";
import { fixedText, percentText } from "../format";
import { useApp } from "../state";
import { useAct } from "../use_act";
import type { ViewChoice } from "./view_settings";

export interface OrderPicturesProps {
  readonly step: OrderStep;
  readonly study: Study | null;
  readonly save: () => Promise<Study>;
  readonly chooseView: (choice: ViewChoice) => void;
}

/** The pictures of an order step, which are rendered from one view in different comforts. */
export function OrderPictures({ step, study, save, chooseView }: OrderPicturesProps) {
  const [round, setRound] = useState(0);
  const urls = useStudyPictures(study?.id ?? null, step, round);
  const text = t.studies;
  const { state, busy, take } = useTaking(step, save, () => setRound((before) => before + 1));
  return (
    <div class="study-pictures" role="group" aria-label={text.pictures}>
      <p class="field-hint">{text.picturesHint}</p>
      <ul>
        {step.pictures.map(({ id, comfort }) => {
          const label = text.picture(signed(comfort));
          const url = urls.get(id);
          return (
            <li key={id}>{url ? <img src={url} alt={label} /> : <span aria-label={label}>{signed(comfort)}</span>}</li>
          );
        })}
      </ul>
      <p role="status">{text.picturesThere(urls.size, step.pictures.length)}</p>
      {state}
      <p>
        <button
          type="button"
          class="button"
          disabled={busy}
          onClick={() => chooseView({ view: null, kind: step.kind, use: take })}
        >
          {urls.size > 0 ? text.picturesAgain : text.picturesTake}
        </button>
      </p>
    </div>
  );
}

const signed = (comfort: number): string => (comfort > 0 ? `+${fixedText(comfort, 0)}` : fixedText(comfort, 0));

/** Renders the pictures and uploads them. */
function useTaking(step: OrderStep, save: () => Promise<Study>, onTaken: () => void) {
  const { app, act, busy, outcome } = useAct();
  const [at, setAt] = useState({ number: 0, done: 0 });
  const taking = useRef<Taking | null>(null);
  useEffect(() => () => taking.current?.stop(), []);
  const take = (view: View) =>
    act(async () => {
      const { id } = await save();
      taking.current = takePictures(app.api, view, step.pictures, {
        progress: (number, done) => setAt({ number, done }),
        taken: (picture, file) => app.api.studies.savePicture(id, picture, file),
      });
      const problem = await taking.current.done;
      onTaken();
      return problem === null ? t.studies.picturesDone : t.studies[problem];
    });
  const progress = (
    <p class="muted" role="status">
      {busy && at.number > 0
        ? `${t.studies.picturesTaking(at.number, step.pictures.length)} ${percentText(at.done)}`
        : ""}
    </p>
  );
  return {
    take,
    busy,
    state: (
      <>
        {progress}
        {outcome}
      </>
    ),
  };
}

/** The pictures that the server has. */
function useStudyPictures(studyId: string | null, step: OrderStep, round: number): ReadonlyMap<string, string> {
  const { api } = useApp();
  const [urls, setUrls] = useState<ReadonlyMap<string, string>>(new Map());
  useEffect(() => {
    if (studyId === null) return;
    const leaving = new AbortController();
    const made: string[] = [];
    for (const { id } of step.pictures)
      api.studies.picture(studyId, id, leaving.signal).then(
        (blob) => {
          const url = URL.createObjectURL(blob);
          made.push(url);
          setUrls((before) => new Map(before).set(id, url));
        },
        () => undefined, // not uploaded yet
      );
    return () => {
      leaving.abort();
      for (const url of made) URL.revokeObjectURL(url);
    };
    // eslint-disable-next-line react-hooks/exhaustive-deps -- the pictures of a step do not change
  }, [api, studyId, round]);
  return urls;
}
