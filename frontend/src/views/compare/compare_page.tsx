import { useEffect, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { useApp } from "../state";
import { OneOverTheOther } from "./one_over_the_other";
import { SideBySide } from "./side_by_side";

export interface ComparePageProps {
  readonly first: string;
  readonly second: string;
  readonly over: boolean;
}

/** Two scans, side by side or one over the other. */
export function ComparePage({ first, second, over }: ComparePageProps) {
  const sets = [useDataSet(first), useDataSet(second)] as const;
  const scans = { first, second, sets };
  return over ? <OneOverTheOther {...scans} /> : <SideBySide {...scans} />;
}

function useDataSet(id: string): DataSet | null {
  const app = useApp();
  const [set, setSet] = useState<DataSet | null>(null);
  useEffect(() => {
    app.api.dataSet(id).then(setSet, () => undefined); // the stream reports the error
  }, [app, id]);
  return set;
}
