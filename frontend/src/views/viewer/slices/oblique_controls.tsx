import { projections, slabLimits, type Projection } from "../../../slices/oblique";
import type { Slices } from "../../../slices/model";
import { t } from "../../../texts";
import { IconButton } from "../../icon_button";
import { Typed } from "./typed";

/**
 * The thickness of the slices, and the way back from tilted ones. Shown with the tool for tilting,
 * and while anything differs from usual, because the toolbar has no room for it on its first line.
 */
export function ObliqueControls({ slices }: { readonly slices: Slices }) {
  const slab = slices.slab.value;
  const usesSlab = slices.tool.value === "tilt" || slices.tool.value === "curve";
  if (!usesSlab && slab.mm === 0 && !slices.tilt.value) return null;
  return (
    <div class="slice-window" role="group" aria-label={t.slices.oblique}>
      <Typed
        label={t.slices.slab}
        title={t.slices.slabHelp}
        value={slab.mm}
        limits={slabLimits}
        take={(mm) => slices.setSlab({ ...slab, mm })}
      />
      {slab.mm > 0 ? (
        <select
          aria-label={t.slices.projection}
          value={slab.projection}
          onChange={(event) => slices.setSlab({ ...slab, projection: event.currentTarget.value as Projection })}
        >
          {projections.map((name) => (
            <option key={name} value={name}>
              {t.slices.projections[name]}
            </option>
          ))}
        </select>
      ) : null}
      {slices.tilt.value ? (
        <IconButton icon="level" label={t.slices.straighten} onClick={() => slices.straighten()} />
      ) : null}
    </div>
  );
}
