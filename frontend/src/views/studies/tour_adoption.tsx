import { ApiProblem } from "../../api/client";
import type { Analysis, Study } from "../../api/studies";
import { hasView, textIn } from "../../studies/definition";
import { language, t } from "../../texts";
import { UserError } from "../state";
import { useAct } from "../use_act";

interface TourAdoptionProps {
  readonly study: Study;
  readonly analysis: Analysis;
}

/** Lets a researcher use the canonical views of a step for the tour of its scan. */
export function TourAdoption({ study, analysis }: TourAdoptionProps) {
  const { app, act, busy, outcome } = useAct();
  const text = t.studies;
  const tours = analysis.adoptable.tours.filter(({ views }) => views.length > 1);
  if (tours.length === 0) return null;
  const adopt = (dataSet: string, step: string) =>
    act(async () => {
      try {
        await app.api.studies.adoptTour(dataSet, study.id, step);
      } catch (thrown) {
        const isForbidden = thrown instanceof ApiProblem && (thrown.status === 403 || thrown.status === 404);
        throw isForbidden ? new UserError(text.tourNotYours) : thrown;
      }
      return text.adoptedTour;
    });
  return (
    <div class="study-adoption">
      <p class="muted">{text.adoptTourText}</p>
      <div class="study-choices">
        {tours.map(({ step, data_set_id: scan }) => (
          <button key={step} type="button" class="button" disabled={busy} onClick={() => adopt(scan, step)}>
            {text.adoptTour(partOf(study, step))}
          </button>
        ))}
      </div>
      {outcome}
    </div>
  );
}

/** Returns the name of the part whose view the participants of a step choose. */
function partOf({ definition }: Study, id: string): string {
  const step = definition.steps.find((one) => one.id === id);
  const region = step && hasView(step) ? step.view?.region : undefined;
  return (region && textIn(region.name, language.value).text) ?? t.studies.wholeScan;
}
