import { useEffect } from "preact/hooks";
import { standardSides } from "../../../input/cube";
import { roleOf } from "../../../live/role";
import { textIn } from "../../../studies/definition";
import { language, t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { useAct } from "../../use_act";
import type { WindowProps } from "./controls";

/** The standard views of the patient, and the tour. */
export function ViewWindow({ session }: WindowProps) {
  const text = t.settings.view;
  const { guide } = session;
  return (
    <>
      <div class="side-views" role="group" aria-label={text.sides}>
        {standardSides.map((letter) => (
          <button
            key={letter}
            type="button"
            class="button"
            aria-keyshortcuts={`Shift+${letter}`}
            onClick={() => guide.viewFrom(letter)}
          >
            {text.from[letter]}
          </button>
        ))}
      </div>
      {roleOf(session.audience.value).presents ? <TourPart session={session} /> : null}
    </>
  );
}

function TourPart({ session }: { readonly session: ViewerSession }) {
  const text = t.settings.view;
  const { tour } = session.guide;
  const study = tour.study.value;
  useEffect(() => {
    void tour.loadStudy();
  }, [tour]);
  return (
    <>
      <p class="hint">
        {study ? text.studyLead(textIn(study.title, language.value).text, study.participants) : text.aroundLead}
      </p>
      <p>
        <button type="button" class="button button-main" aria-keyshortcuts="T" onClick={() => void tour.toggle()}>
          {tour.state.value !== "off" ? text.stop : text.around}
        </button>
      </p>
      <StudyRemoval session={session} />
    </>
  );
}

/** Lets those who may choose the tour of a scan use computed views again. */
function StudyRemoval({ session }: { readonly session: ViewerSession }) {
  const { app, act, busy, outcome } = useAct();
  const { tour } = session.guide;
  const scan = session.dataSetId;
  const isPossible = tour.study.value?.removable === true && scan !== null;
  return (
    <>
      {isPossible ? (
        <p>
          <button
            type="button"
            class="button"
            disabled={busy}
            onClick={() =>
              act(async () => {
                await app.api.studies.removeTour(scan);
                tour.forgetStudy();
                return t.settings.view.studyRemoved;
              })
            }
          >
            {t.settings.view.removeStudy}
          </button>
        </p>
      ) : null}
      {outcome}
    </>
  );
}
