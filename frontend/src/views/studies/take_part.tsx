import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import { randomKey } from "../../api/random_key";
import type { JoinedStudy, StudyInvitation } from "../../api/studies";
import { after } from "../../live/paced";
import { tab } from "../../storage";
import { keepParticipant, keptParticipant, Participation, queueOf, type Ending } from "../../studies/participation";
import { patiently } from "../../studies/patiently";
import { language, t } from "../../texts";
import { problemText } from "../../texts/problem_text";
import { Loading } from "../loading";
import { Notice, PageTitle } from "../shell";
import { useApp } from "../state";
import { EndPage } from "./end_page";
import { InvitationForm } from "./invitation";
import { StudyMessage } from "./study_frame";
import { StudySteps } from "./study_steps";

/** The page of a participant: the invitation, the steps and the end. It needs no account. */
export function TakePartByLink({ token }: { readonly token: string }) {
  const { kept, joined, fault, join, end, again } = useJoining(token);
  const invitation = useInvitation(token, kept === null);
  if (kept?.ended) return <EndPage ending={kept.ended} participant={kept.key} again={again} />;
  if (joined && kept) return <Steps key={kept.key} joined={joined} participant={kept} end={end} />;
  if (kept) return <Joining fault={fault} />;
  if (invitation.found) return <InvitationForm invitation={invitation.found} fault={fault} join={join} />;
  return <NoInvitation fault={invitation.fault} gone={invitation.gone} />;
}

function Joining({ fault }: { readonly fault: string }) {
  return (
    <StudyMessage>
      <PageTitle text={t.name} />
      {fault ? <Notice kind="info">{fault}</Notice> : <Loading />}
    </StudyMessage>
  );
}

function NoInvitation({ fault, gone }: { readonly fault: string; readonly gone: boolean }) {
  return (
    <StudyMessage>
      <PageTitle text={gone ? t.takePart.goneTitle : t.name} />
      {fault ? <Notice kind="info">{fault}</Notice> : <Loading />}
    </StudyMessage>
  );
}

/** Loads the invitation, and tries again while the server is not there. */
function useInvitation(token: string, wanted: boolean) {
  const { api } = useApp();
  const [found, setFound] = useState<StudyInvitation | null>(null);
  const [fault, setFault] = useState("");
  const [gone, setGone] = useState(false);
  useEffect(() => {
    if (!wanted) return;
    return patiently(() => api.studies.invitation(token), {
      done: setFound,
      refused: (thrown) => {
        setGone(true);
        setFault(goneText(thrown));
      },
      waiting: () => setFault(t.takePart.joining),
    });
  }, [api, token, wanted]);
  return { found, fault, gone };
}

function goneText(thrown: unknown): string {
  if (!(thrown instanceof ApiProblem) || thrown.status !== 410) return t.takePart.gone;
  return thrown.kind === "study-full" ? t.takePart.full : t.takePart.closed;
}

/** Joins as a new participant, or after a reload as the one whose key this tab has kept. */
function useJoining(token: string) {
  const { api } = useApp();
  const [kept, setKept] = useState(() => reopened(keptParticipant(tab, token)));
  const [joined, setJoined] = useState<JoinedStudy | null>(null);
  const [fault, setFault] = useState("");
  const continues = kept !== null && kept.ended === null && joined === null;
  useEffect(() => {
    if (!continues) return;
    let stopQueue: () => void = () => undefined;
    const stop = patiently(() => api.studies.join(token, kept.key, language.value, kept.record), {
      done: setJoined,
      refused: (thrown) => {
        // The link has ended, but the key may still be known.
        const queue = queueOf(api.studies, kept.key, tab, after);
        stopQueue = () => queue.stop();
        void queue.whenEmpty().then(() => end(isGone(thrown) ? "gone" : (queue.over.value ?? "over")));
      },
      waiting: () => setFault(t.takePart.joining),
    });
    return () => {
      stop();
      stopQueue();
    };
    // eslint-disable-next-line react-hooks/exhaustive-deps -- `end` is new in each render
  }, [api, token, continues, kept]);
  /** A repeated request joins as the same participant, also if only the answer to the first one was lost. */
  const key = useRef("");
  const join = async (record: boolean): Promise<void> => {
    key.current ||= randomKey() + randomKey();
    const participant = { key: key.current, record, ended: null };
    setFault("");
    try {
      const now = await api.studies.join(token, participant.key, language.value, record);
      keepParticipant(tab, token, participant);
      setKept(participant);
      setJoined(now);
    } catch (thrown) {
      setFault(joinFault(thrown));
    }
  };
  const end = (ending: Ending) => {
    if (!kept) return;
    const ended = { ...kept, ended: ending };
    keepParticipant(tab, token, ended);
    setKept(ended);
  };
  /** Tries to continue with a study that was closed. */
  const again = () => {
    setJoined(null);
    setKept(reopened(kept));
  };
  return { kept, joined, fault, join, end, again };
}

function joinFault(thrown: unknown): string {
  if (!(thrown instanceof ApiProblem)) return t.problems.internal;
  return thrown.status === 410 ? goneText(thrown) : problemText(thrown);
}

type Kept = ReturnType<typeof keptParticipant>;
const reopened = (kept: Kept): Kept => (kept?.ended === "over" ? { ...kept, ended: null } : kept);
const isGone = (thrown: unknown): boolean => thrown instanceof ApiProblem && thrown.kind === "participation-ended";

interface StepsProps {
  readonly joined: JoinedStudy;
  readonly participant: { readonly key: string; readonly record: boolean };
  readonly end: (ending: Ending) => void;
}

function Steps({ joined, participant: { key, record }, end }: StepsProps) {
  const { api } = useApp();
  const participation = useMemo(
    () => new Participation(api.studies, key, joined, record, tab, after),
    [api, key, joined, record],
  );
  const endHere = (ending: Ending) => {
    if (ending !== "over") participation.forgetSteps();
    end(ending);
  };
  return <StudySteps participation={participation} end={endHere} />;
}
