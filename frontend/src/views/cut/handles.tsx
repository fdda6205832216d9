import { useRef, useState } from "preact/hooks";
import { handlesToTake, moved, planeInRegion, rangeOf, type Handle, type Region } from "../../cut/region";
import { dragged, type Box, type Eye } from "../../picture/project";
import { t } from "../../texts";
import { BoxLines, PlaneShape } from "../picture/box_lines";
import { HandleButton } from "../picture/handle_button";
import { useScreen } from "../picture/use_screen";

export const nameOf = (handle: Handle): string =>
  handle.kind === "plane" ? t.cut.plane : t.cut.faces[handle.axis][handle.side];
export const keyOf = (handle: Handle): string => (handle.kind === "plane" ? "plane" : `${handle.axis}-${handle.side}`);

export interface HandlesProps {
  readonly eye: Eye;
  readonly region: Region;
  readonly bounds: Box;
  readonly change: (region: Region, rest: boolean) => void;
}

/** The box and the plane over the picture, with a handle per face. */
export function Handles({ eye, region, bounds, change }: HandlesProps) {
  const area = useRef<HTMLDivElement>(null);
  const [held, setHeld] = useState<Handle | null>(null);
  const screen = useScreen(area);
  return (
    <div class="handle-area cut-area" ref={area} role="region" aria-label={t.cut.area}>
      <svg aria-hidden="true" width={screen.width} height={screen.height}>
        <BoxLines eye={eye} screen={screen} box={region} />
        <PlaneShape eye={eye} screen={screen} polygon={planeInRegion(region)} />
      </svg>
      {handlesToTake(eye, screen, region, held).map((placed) => {
        const { handle, place, along } = placed;
        const range = rangeOf(handle, region, bounds);
        return (
          <HandleButton
            key={keyOf(handle)}
            name={keyOf(handle)}
            label={nameOf(handle)}
            look={handle.kind}
            at={placed}
            low={range.low}
            high={range.high}
            now={range.at}
            valueText={t.cut.mm(Math.round(range.at))}
            drag={(to) => {
              const by = dragged(eye, screen, place, along, { x: to.x - placed.x, y: to.y - placed.y });
              if (by !== null) change(moved(handle, range.at + by, region, bounds), false);
            }}
            step={(right, up) => change(moved(handle, range.at + right + up, region, bounds), true)}
            rest={() => change(region, true)}
            hold={(on) => setHeld((before) => (on ? handle : before === handle ? null : before))}
          />
        );
      })}
    </div>
  );
}
