import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  ClientMessageSchema,
  ConfigSchema,
  ServerMessageSchema,
  type ClientMessage,
  type ServerMessage,
} from "../protocol/gen/api/proto/stream_pb";
import type { TicketSource, SocketEvents } from "../protocol/stream_client";
import { someScene } from "../scene/testing";
import type { BackgroundParts } from "./background_session";

export const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

/** A worker by hand, for a session that no user sees. */
export abstract class WorkerByHand<State> {
  abstract readonly shot: { start(): void };
  states: State[] = [];
  sent: ClientMessage[] = [];
  socket: SocketEvents | null = null;
  open = true;
  ticketSource: TicketSource = () => Promise.resolve({ ok: true, url: "/stream" });

  readonly parts: BackgroundParts<State> = {
    ticketSource: (signal) => this.ticketSource(signal),
    openSocket: (_, events) => {
      this.socket = events;
      return {
        send: (data) => this.sent.push(fromBinary(ClientMessageSchema, data)),
        close: () => (this.open = false),
      };
    },
    after: (ms, task) => {
      if (ms === 0) queueMicrotask(task);
      return () => undefined;
    },
    state: (state) => this.states.push(state),
  };

  say(body: ServerMessage["body"]): void {
    this.socket?.message(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body })));
  }
  config(): void {
    this.say({ case: "config", value: create(ConfigSchema, { scene: someScene() }) });
  }
  async live(): Promise<void> {
    this.shot.start();
    await settled();
    this.socket?.opened();
    this.config();
    await settled();
  }
  get cases(): (string | undefined)[] {
    return this.sent.map(({ body }) => body.case);
  }
  get state(): State | undefined {
    return this.states.at(-1);
  }
}
