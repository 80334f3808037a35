"""The interpreter's end, whatever other threads are doing, and outputs that would replace what they come from."""

import os
import subprocess
import sys
import tempfile
import textwrap
import unittest

import _module  # noqa: F401  (where the module is)
import balance_mechanisms as bm
