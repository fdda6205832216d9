import { useEffect } from "preact/hooks";
import { t } from "../../../texts";
import { useApp } from "../../state";
import { useLatest } from "../../use_latest";
import { mostKeyViews, type KeyView } from "./video_size";

export interface ViewListProps {
  readonly dataSetId: string;
  readonly views: readonly KeyView[];
  readonly onViews: (views: readonly KeyView[]) => void;
  readonly onFault: (fault: string) => void;
}

/** The key views of a tour and their order. */
export function ViewList({ dataSetId, views, onViews, onFault }: ViewListProps) {
  useKeyViews(dataSetId, onViews, onFault);
  const text = t.take;
  const moveUp = (n: number) => {
    const view = views[n];
    const above = views[n - 1];
    if (view && above) onViews([...views.slice(0, n - 1), view, above, ...views.slice(n + 1)]);
  };
  const take = (n: number, taken: boolean) => onViews(views.map((one, i) => (i === n ? { ...one, taken } : one)));
  return (
    <fieldset class="take-views">
      <legend>{text.views}</legend>
      {views.length === 1 ? <p class="field-hint">{text.noViews}</p> : null}
      <ol>
        {views.map((view, n) => {
          const name = view.preset?.name ?? text.viewNow;
          return (
            <li key={view.preset?.id ?? ""}>
              <label>
                <input
                  type="checkbox"
                  checked={view.taken}
                  onChange={(event) => take(n, event.currentTarget.checked)}
                />
                {name}
              </label>
              <button
                type="button"
                class="button button-small"
                aria-label={text.earlierOf(name)}
                aria-disabled={n === 0}
                onClick={() => moveUp(n)}
              >
                {text.earlier}
              </button>
            </li>
          );
        })}
      </ol>
    </fieldset>
  );
}

/** Reads the saved presets of the scan once and lists them after the current view. */
function useKeyViews(dataSetId: string, onViews: ViewListProps["onViews"], onFault: ViewListProps["onFault"]): void {
  const app = useApp();
  const latest = useLatest({ onViews, onFault });
  useEffect(() => {
    let current = true;
    app.api.presets.list(dataSetId).then(
      (list) => {
        if (current) latest.current.onViews([null, ...list].map((preset, n) => ({ preset, taken: n < mostKeyViews })));
      },
      (thrown: unknown) => {
        if (current) latest.current.onFault(app.explain(thrown));
      },
    );
    return () => {
      current = false;
    };
  }, [app, dataSetId, latest]);
}
