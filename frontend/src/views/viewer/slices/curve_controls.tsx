import { heightLimits } from "../../../slices/curve_view";
import type { Slices } from "../../../slices/model";
import { t } from "../../../texts";
import { IconButton } from "../../icon_button";
import { Typed } from "./typed";

/** The size of the slice along the curve, and the ways back. Shown with the tool, and while there is a curve. */
export function CurveControls({ slices }: { readonly slices: Slices }) {
  const { curve, tool } = slices;
  const none = curve.points.value.length === 0;
  if (slices.access.value === "shown" || (tool.value !== "curve" && none)) return null;
  return (
    <div class="slice-window" role="group" aria-label={t.slices.curve.name}>
      <Typed
        label={t.slices.curve.height}
        title={t.slices.curve.heightHelp}
        value={curve.height.value}
        limits={heightLimits}
        take={(height) => curve.setHeight(height)}
      />
      <IconButton icon="undo" label={t.slices.curve.undo} disabled={none} onClick={() => curve.undo()} />
      <IconButton icon="close" label={t.slices.curve.clear} disabled={none} onClick={() => curve.clear()} />
    </div>
  );
}
