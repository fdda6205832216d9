import type { ComponentType } from "preact";
import { useEffect, useState } from "preact/hooks";
import { t } from "../texts";
import { Loading } from "./loading";
import { Notice } from "./shell";

/** Returns a page whose code is loaded when it is opened for the first time, because most people never open it. */
export function lazyPage<Props extends object>(load: () => Promise<ComponentType<Props>>): ComponentType<Props> {
  let loaded: ComponentType<Props> | null = null;
  return function LazyPage(props: Props) {
    const [state, setState] = useState<"loading" | "ready" | "failed">(loaded ? "ready" : "loading");
    useEffect(() => {
      if (loaded) return;
      load().then(
        (page) => {
          loaded = page;
          setState("ready");
        },
        () => setState("failed"),
      );
    }, []);
    const Page = loaded;
    if (Page) return <Page {...props} />;
    return state === "failed" ? <Notice kind="bad">{t.legal.failed}</Notice> : <Loading page />;
  };
}
