"""Files dragged from another program and dropped on a window, as file managers do it (XDND, version 5), by libX11.

    DraggedFiles(environment["DISPLAY"]).drop(window_id, (x, y), ["/models/bunny.obj"])
"""
import ctypes
import ctypes.util
import time

PATIENCE = 60  # seconds
CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31

Id = ctypes.c_ulong


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", Id), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", Id), ("message_type", Id), ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", Id), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("owner", Id), ("requestor", Id), ("selection", Id), ("target", Id), ("property", Id), ("time", Id)]


class Selection(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", Id), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("requestor", Id), ("selection", Id), ("target", Id), ("property", Id), ("time", Id)]


class Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("message", ClientMessage), ("request", SelectionRequest),
                ("selection", Selection), ("room", ctypes.c_long * 24)]


class DraggedFiles:
    def __init__(self, display):
        self._x = ctypes.CDLL(ctypes.util.find_library("X11"))
        self._x.XOpenDisplay.restype = ctypes.c_void_p
        for function in (self._x.XInternAtom, self._x.XDefaultRootWindow, self._x.XCreateSimpleWindow):
            function.restype = Id
        self._display = ctypes.c_void_p(self._x.XOpenDisplay(display.encode()))
        assert self._display, f"no display {display}"
        root = self._x.XDefaultRootWindow(self._display)
        self._source = self._x.XCreateSimpleWindow(self._display, Id(root), 0, 0, 1, 1, 0, Id(0), Id(0))

    def drop(self, window, position, paths):
        """At a position on the screen; returns once the window has taken the files."""
        uris = "".join(f"file://{path}\r\n" for path in paths).encode()
        kind = self._atom("text/uri-list")
        selection = self._atom("XdndSelection")
        self._x.XSetSelectionOwner(self._display, Id(selection), Id(self._source), Id(0))
        self._send(window, "XdndEnter", 5 << 24, kind)
        self._send(window, "XdndPosition", 0, position[0] << 16 | position[1], 0, self._atom("XdndActionCopy"))
        status = self._next(CLIENT_MESSAGE).message
        assert status.message_type == self._atom("XdndStatus") and status.data[1] & 1, "the window takes no files"
        self._send(window, "XdndDrop", 0, 0)
        request = self._next(SELECTION_REQUEST).request
        self._x.XChangeProperty(self._display, Id(request.requestor), Id(request.property), Id(request.target), 8, 0,
                                uris, len(uris))
        answer = Event()
        answer.selection = Selection(SELECTION_NOTIFY, 0, 0, None, request.requestor, request.selection,
                                     request.target, request.property, request.time)
        self._x.XSendEvent(self._display, Id(request.requestor), 0, ctypes.c_long(0), ctypes.byref(answer))
        finished = self._next(CLIENT_MESSAGE).message
        assert finished.message_type == self._atom("XdndFinished"), "the window does not say that it is done"

    def close(self):
        self._x.XCloseDisplay(self._display)

    def _atom(self, name):
        return self._x.XInternAtom(self._display, name.encode(), 0)

    def _send(self, window, name, *words):
        event = Event()
        data = (ctypes.c_long * 5)(self._source, *words)
        event.message = ClientMessage(CLIENT_MESSAGE, 0, 0, None, window, self._atom(name), 32, data)
        self._x.XSendEvent(self._display, Id(window), 0, ctypes.c_long(0), ctypes.byref(event))
        self._x.XFlush(self._display)

    def _next(self, kind):
        end = time.monotonic() + PATIENCE
        event = Event()
        while time.monotonic() < end:
            self._x.XFlush(self._display)
            while self._x.XPending(self._display):
                self._x.XNextEvent(self._display, ctypes.byref(event))
                if event.type == kind:
                    return event
            time.sleep(0.01)
        raise AssertionError(f"no event {kind} came")
