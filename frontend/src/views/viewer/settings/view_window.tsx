import { standardSides } from "../../../input/cube";
import { roleOf } from "../../../live/role";
import { t } from "../../../texts";
import type { WindowProps } from "./controls";

/** The standard views of the patient, and the tour. */
export function ViewWindow({ session }: WindowProps) {
  const text = t.settings.view;
  const { guide } = session;
  const running = guide.tour.state.value !== "off";
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
      {roleOf(session.audience.value).presents ? (
        <>
          <p class="hint">{text.aroundLead}</p>
          <p>
            <button
              type="button"
              class="button button-main"
              aria-keyshortcuts="T"
              onClick={() => void guide.tour.toggle()}
            >
              {running ? text.stop : text.around}
            </button>
          </p>
        </>
      ) : null}
    </>
  );
}
