import type { Step, View, ViewStep } from "../../studies/definition";
import { withStepView } from "../../studies/materials";
import { t } from "../../texts";
import { titleOf } from "../scan_card";
import { useViewScans } from "./use_view_scans";

export interface ViewFieldProps {
  readonly step: ViewStep;
  /** The picture of another step, which this one can use too. */
  readonly other: View | null;
  readonly change: (step: Step) => void;
  readonly choose: () => void;
}

/** The picture of a step. */
export function ViewField({ step, other, change, choose }: ViewFieldProps) {
  const text = t.studies;
  const scans = useViewScans();
  const { view } = step;
  const scan = scans?.find(({ id }) => id === view?.data_set_id);
  const withoutView = () => {
    const rest = { ...step };
    delete rest.view;
    change(rest);
  };
  return (
    <div class="study-view" role="group" aria-label={text.view}>
      <p>{view ? text.viewOf(scan ? titleOf(scan) : text.unknownScan, view.preset) : text.viewNone}</p>
      {step.kind === "rating" && !view ? <p class="field-hint">{text.scaleOptional}</p> : null}
      <div class="study-choices">
        <button type="button" class="button" onClick={choose}>
          {view ? text.changeView : text.chooseView}
        </button>
        {!view && other ? (
          <button type="button" class="button" onClick={() => change(withStepView(step, other))}>
            {text.copyView}
          </button>
        ) : null}
        {view && step.kind === "rating" ? (
          <button type="button" class="button" onClick={withoutView}>
            {text.removeView}
          </button>
        ) : null}
      </div>
    </div>
  );
}
